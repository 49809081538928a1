#include "culling/report/svg.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace culld::report {
namespace {

constexpr std::array<Style, kStyles> kAllStyles{{{"#0072b2", "", 0, false},
                                                 {"#d55e00", "7 3", 1, false},
                                                 {"#009e73", "2 3", 2, false},
                                                 {"#cc79a7", "9 3 2 3", 3, false},
                                                 {"#e69f00", "4 2", 4, false},
                                                 {"#56b4e9", "1 2", 5, false},
                                                 {"#6b5b00", "12 4", 6, false},
                                                 {"#0072b2", "7 3", 3, true},
                                                 {"#d55e00", "", 4, true},
                                                 {"#009e73", "9 3 2 3", 5, true},
                                                 {"#cc79a7", "4 2", 6, true},
                                                 {"#e69f00", "12 4", 0, true},
                                                 {"#56b4e9", "7 3", 1, true},
                                                 {"#6b5b00", "2 3", 2, true}}};
constexpr Style kRing{"#222222", "3 2", -1, true};

std::string printed(const char* format, double value) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

std::string withUnit(double value, const char* unit) { return shortNumber(value) + " " + unit; }

/// Length of the well-formed UTF-8 character that `text` begins with; 0 if it is none.
std::size_t characterLength(std::string_view text) {
  const auto byte = [&](std::size_t i) {
    return i < text.size() ? static_cast<unsigned char>(text[i]) : 0U;
  };
  const auto follows = [&](std::size_t i) { return (byte(i) & 0xC0U) == 0x80U; };
  if (byte(0) < 0x80U) return byte(0) >= 0x20U || byte(0) == '\n' || byte(0) == '\t' ? 1 : 0;
  if (byte(0) >= 0xC2U && byte(0) < 0xE0U && follows(1)) return 2;
  if ((byte(0) & 0xF0U) == 0xE0U && follows(1) && follows(2)) return 3;
  if (byte(0) >= 0xF0U && byte(0) < 0xF5U && follows(1) && follows(2) && follows(3)) return 4;
  return 0;
}

std::string points(std::initializer_list<std::array<double, 2>> corners) {
  std::string text;
  for (const auto& c : corners) text += coordinate(c[0]) + "," + coordinate(c[1]) + " ";
  return text;
}

std::string polygon(const std::string& look, std::initializer_list<std::array<double, 2>> corners) {
  return "<polygon points=\"" + points(corners) + "\"" + look + "/>";
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string out;
  while (!text.empty()) {
    const std::size_t length = characterLength(text);
    const std::string_view character = text.substr(0, std::max<std::size_t>(1, length));
    text.remove_prefix(character.size());
    if (length == 0) {
      out += '?';
    } else if (character == "&") {
      out += "&amp;";
    } else if (character == "<") {
      out += "&lt;";
    } else if (character == ">") {
      out += "&gt;";
    } else if (character == "\"") {
      out += "&quot;";
    } else {
      out += character;
    }
  }
  return out;
}

std::string shortNumber(double value) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  if (size != 0.0 && (size >= 1e12 || size < 1e-4)) return printed("%.3g", value);
  if (size >= 999.5) {
    std::string digits = printed("%.0f", value);
    const std::size_t sign = value < 0.0 ? 1 : 0;
    for (std::size_t at = digits.size(); at > sign + 3; at -= 3) digits.insert(at - 3, "\u2009");
    return digits;
  }
  const int before = size < 1.0 ? 0 : static_cast<int>(std::floor(std::log10(size))) + 1;
  const int leading = size != 0.0 && size < 0.1 ? static_cast<int>(-std::log10(size)) : 0;
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%.*f", std::max(0, 3 - before + leading), value);
  std::string digits = text.data();
  if (digits.find('.') != std::string::npos) {
    digits.erase(digits.find_last_not_of('0') + 1);
    if (digits.back() == '.') digits.pop_back();
  }
  return digits;
}

std::string shortBytes(double bytes) {
  if (!(std::abs(bytes) >= 999.5)) return withUnit(bytes, "B");
  if (std::abs(bytes) < 999.5e3) return withUnit(bytes * 1e-3, "kB");
  if (std::abs(bytes) < 999.5e6) return withUnit(bytes * 1e-6, "MB");
  return withUnit(bytes * 1e-9, "GB");
}

std::string shortTime(double microseconds) {
  const double size = std::abs(microseconds);
  if (size > 0.0 && size < 0.9995) return withUnit(microseconds * 1e3, "ns");
  if (!(size >= 999.5)) return withUnit(microseconds, "\u00b5s");
  if (size < 999.5e3) return withUnit(microseconds * 1e-3, "ms");
  return withUnit(microseconds * 1e-6, "s");
}

std::string percent(const std::optional<double>& share) {
  if (!share) return "-";
  const double tenths = std::round(1000.0 * *share) + 0.0;  // no "-0.0"
  return printed("%.1f %%", 0.1 * tenths);
}

std::string coordinate(double px) {
  std::string text = printed("%.1f", px);
  if (text.size() > 2 && text.substr(text.size() - 2) == ".0") text.resize(text.size() - 2);
  return text;
}

std::vector<Tick> linearTicks(double low, double high, int most) {
  const double rough = (high - low) / most;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  double step = 10.0 * power;
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * power >= rough) {
      step = factor * power;
      break;
    }
  }
  std::vector<Tick> ticks;
  const double slack = 1e-9 * step;
  for (double n = std::ceil((low - slack) / step); n * step <= high + slack; n += 1.0) {
    const double value = n * step == 0.0 ? 0.0 : n * step;  // no "-0"
    ticks.push_back({value, shortNumber(value)});
  }
  return ticks;
}

std::vector<Tick> logTicks(double low, double high) {
  const double decades = std::log10(high) - std::log10(low);
  const double every = std::max(1.0, std::ceil(decades / 6.0));
  std::vector<double> factors{1.0};
  if (decades < 3.0) factors = {1.0, 2.0, 5.0};
  if (decades < 1.0) factors = {1.0, 1.5, 2.0, 3.0, 5.0, 7.0};
  std::vector<Tick> ticks;
  const double slack = 1e-9;
  for (double power = std::floor(std::log10(low)); power <= std::log10(high) + slack;
       power += 1.0) {
    if (std::fmod(std::abs(power), every) != 0.0) continue;
    for (const double factor : factors) {
      const double value = factor * std::pow(10.0, power);
      if (value >= low * (1 - slack) && value <= high * (1 + slack)) {
        ticks.push_back({value, shortNumber(value)});
      }
    }
  }
  return ticks.size() < 3 && decades < 1.0 ? linearTicks(low, high, 5) : ticks;
}

Axis::Axis(Kind kind, const std::vector<double>& values, double from_px, double to_px)
    : kind_(kind), from_px_(from_px), to_px_(to_px) {
  kind == Kind::kLinear ? fitLinear(values) : fitLog(values);
}

void Axis::fitLinear(const std::vector<double>& values) {
  std::vector<double> finite = values;
  std::erase_if(finite, [](double v) { return !std::isfinite(v); });
  if (!finite.empty()) {
    const auto [least, most] = std::minmax_element(finite.begin(), finite.end());
    low_ = *least;
    high_ = *most;
  }
  const double size = std::max(std::abs(low_), std::abs(high_));
  if (!(high_ - low_ > 1e-9 * size)) {
    low_ -= size > 0.0 ? 0.5 * size : 0.5;
    high_ += size > 0.0 ? 0.5 * size : 0.5;
  }
  ticks_ = linearTicks(low_, high_);
}

void Axis::fitLog(const std::vector<double>& values) {
  std::vector<double> fit = values;
  std::erase_if(fit, [](double v) { return !(v > 0.0) || !std::isfinite(v); });
  low_ = 0.0;
  high_ = 2.0;
  if (!fit.empty()) {
    const auto [least, most] = std::minmax_element(fit.begin(), fit.end());
    low_ = std::log10(*least);
    high_ = std::log10(*most);
    const double decades = high_ - low_;
    const double margin = std::max(0.06, 0.06 * decades) + (decades < 0.18 ? 0.1 : 0.0);
    low_ = std::max(low_ - margin, -307.0);
    high_ = std::min(high_ + margin, 308.0);
  }
  ticks_ = logTicks(std::pow(10.0, low_), std::pow(10.0, high_));
  if (kind_ == Kind::kLogWithZero) ticks_.insert(ticks_.begin(), {0.0, "0"});
}

double Axis::at(double value) const {
  const double length = to_px_ - from_px_;
  if (kind_ == Kind::kLinear) return from_px_ + (value - low_) / (high_ - low_) * length;
  const double start = kind_ == Kind::kLogWithZero ? kZeroShare : 0.0;
  if (!(value > 0.0)) return from_px_ + 0.4 * start * length;
  const double share = (std::log10(value) - low_) / (high_ - low_);
  return from_px_ + (start + (1.0 - start) * share) * length;
}

Style styleOf(std::size_t series) {
  return series == kRingStyle ? kRing : kAllStyles[series % kStyles];
}

std::string marker(std::size_t series, double x, double y, double r) {
  const Style style = styleOf(series);
  const std::string color = style.color;
  const std::string look = style.hollow
                               ? " fill=\"#fff\" stroke=\"" + color + "\" stroke-width=\"1.6\""
                               : " fill=\"" + color + "\" stroke=\"#fff\" stroke-width=\"1\"";
  const std::string center = " cx=\"" + coordinate(x) + "\" cy=\"" + coordinate(y) + "\"";
  switch (style.shape) {
    case -1:
      return "<circle" + center + " r=\"" + coordinate(r + 3.0) + "\" fill=\"none\" stroke=\"" +
             color + "\" stroke-width=\"1.8\"/>";
    case 0:
      return "<circle" + center + " r=\"" + coordinate(r) + "\"" + look + "/>";
    case 1:
      return polygon(look, {{x - 0.9 * r, y - 0.9 * r},
                            {x + 0.9 * r, y - 0.9 * r},
                            {x + 0.9 * r, y + 0.9 * r},
                            {x - 0.9 * r, y + 0.9 * r}});
    case 2:
      return polygon(look,
                     {{x, y - 1.2 * r}, {x + 1.1 * r, y + 0.8 * r}, {x - 1.1 * r, y + 0.8 * r}});
    case 3:
      return polygon(look,
                     {{x, y - 1.3 * r}, {x + 1.3 * r, y}, {x, y + 1.3 * r}, {x - 1.3 * r, y}});
    case 4:
      return polygon(look,
                     {{x, y + 1.2 * r}, {x + 1.1 * r, y - 0.8 * r}, {x - 1.1 * r, y - 0.8 * r}});
    case 5:
      return polygon(look, {{x - 1.3 * r, y - 0.6 * r},
                            {x + 1.3 * r, y - 0.6 * r},
                            {x + 1.3 * r, y + 0.6 * r},
                            {x - 1.3 * r, y + 0.6 * r}});
    default:
      return polygon(look, {{x - 0.6 * r, y - 1.3 * r},
                            {x + 0.6 * r, y - 1.3 * r},
                            {x + 0.6 * r, y + 1.3 * r},
                            {x - 0.6 * r, y + 1.3 * r}});
  }
}

}  // namespace culld::report
