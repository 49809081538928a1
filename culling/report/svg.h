// Small parts of SVG drawings: numbers for people, scales with ticks, markers that differ in shape
// as well as in colour, so that no reader depends on colours alone.
#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace culld::report {

/// For text and attributes of HTML and SVG. What is not UTF-8 becomes "?".
std::string escaped(std::string_view text);

/// Three significant digits, thousands apart: "0.0123", "12.3", "1 230", "2.5e+12"; "-" if not
/// finite.
std::string shortNumber(double value);
/// "640 B", "1.5 kB", "12.3 MB".
std::string shortBytes(double bytes);
/// "850 ns", "12.3 \u00b5s", "4.5 ms", "2.1 s".
std::string shortTime(double microseconds);
/// "88.4 %" of 0.884; "-" of none.
std::string percent(const std::optional<double>& share);

/// A coordinate, to a tenth of a pixel.
std::string coordinate(double px);

struct Tick {
  double value = 0.0;
  std::string label;
};

/// Round values within the range, at most about `most`. REQUIRES: low < high, finite.
std::vector<Tick> linearTicks(double low, double high, int most = 6);
/// Powers of ten; with 2 and 5 or finer between them where the range is short.
/// REQUIRES: 0 < low < high, finite.
std::vector<Tick> logTicks(double low, double high);

/// Where on the page a value stands. Values that are not finite stand nowhere: keep them away.
class Axis {
 public:
  enum class Kind {
    kLinear,
    kLog,          ///< values above 0
    kLogWithZero,  ///< 0 has a place of its own, below the smallest value and apart from it
  };
  /// Wide enough for `values` and a little more; some range even for one value, or none.
  Axis(Kind kind, const std::vector<double>& values, double from_px, double to_px);

  double at(double value) const;
  const std::vector<Tick>& ticks() const { return ticks_; }
  /// Where 0 is separated from the logarithmic part.
  double breakAt() const { return from_px_ + 0.5 * kZeroShare * (to_px_ - from_px_) * 1.5; }
  bool hasZeroPlace() const { return kind_ == Kind::kLogWithZero; }

 private:
  static constexpr double kZeroShare = 0.14;
  void fitLinear(const std::vector<double>& values);
  void fitLog(const std::vector<double>& values);

  Kind kind_;
  double from_px_, to_px_;
  double low_ = 0.0, high_ = 1.0;  // of the logarithm, if it is one
  std::vector<Tick> ticks_;
};

/// How one series looks everywhere in a report.
struct Style {
  const char* color;
  const char* dash;  ///< stroke-dasharray; "" is a solid line
  int shape;
  bool hollow;  ///< the marker is an outline
};
inline constexpr std::size_t kStyles = 14;  ///< before they come again
/// The first ones differ most; from the eighth on colours come again, with hollow markers. The
/// colours are Okabe and Ito's, for all kinds of colour vision.
Style styleOf(std::size_t series);
/// The style of a choice among the other series: a ring that lets them be seen through it.
inline constexpr std::size_t kRingStyle = 1000;

std::string marker(std::size_t series, double x, double y, double radius);

}  // namespace culld::report
