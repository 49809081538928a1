// A drawing surface (cairo) with the look that all pictures share: colours, lettering, the legend.
#pragma once
#include <cairo/cairo.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "culling/core/result.h"
#include "culling/report/frame_picture.h"

namespace culld::report {

struct Color {
  double red = 0, green = 0, blue = 0, alpha = 1;
  Color faded(double to) const { return {red, green, blue, alpha * to}; }
};

Color mixed(const Color& a, const Color& b, double share_of_b);

/// As Canvas::image() takes it. REQUIRES: alpha within 0 and 1.
std::uint32_t packed(const Color& color);

inline constexpr Color kNight{0.055, 0.075, 0.105};
inline constexpr Color kDusk{0.120, 0.165, 0.225};
inline constexpr Color kPaper{0.925, 0.945, 0.965};
inline constexpr Color kQuiet{0.560, 0.620, 0.690};

Color colorOf(Verdict verdict);

/// Grows pictures by a footer below the image proper.
inline constexpr std::uint32_t kFooterPx = 84;

class Canvas {
 public:
  Canvas(std::uint32_t width_px, std::uint32_t height_px);
  cairo_t* pen() const { return pen_.get(); }
  double width() const { return width_; }
  double height() const { return height_; }

  void color(const Color& color) const;
  void fillRect(double x, double y, double width, double height, const Color& color) const;
  /// Returns the width written. (x, y) is the left end of the base line.
  double text(double x, double y, double size, const Color& color, const std::string& line,
              bool bold = false) const;
  /// Title, and how many objects have which verdict.
  void footer(const FrameToDraw& frame) const;
  /// Lays packed pixels, row by row, over the upper left corner, scaled down.
  void image(std::span<const std::uint32_t> pixels, std::uint32_t width_px, std::uint32_t height_px,
             double scale) const;
  Result<void> save(const std::string& path_png) const;
  /// The bytes that save() would write.
  Result<std::string> png() const;

 private:
  struct Release {
    void operator()(cairo_surface_t* surface) const noexcept { cairo_surface_destroy(surface); }
    void operator()(cairo_t* pen) const noexcept { cairo_destroy(pen); }
  };
  double width_, height_;
  std::unique_ptr<cairo_surface_t, Release> surface_;
  std::unique_ptr<cairo_t, Release> pen_;
};

/// "12 345": thousands apart.
std::string grouped(std::uint64_t number);

}  // namespace culld::report
