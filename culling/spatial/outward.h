// Sums and differences rounded in a chosen direction without touching the processor's rounding
// mode: the exact error of a sum is itself a double (Knuth's TwoSum), and its sign says which way
// to step. Valid for finite arguments and gradual underflow (the default state of the processor).
#pragma once
#include <cmath>
#include <limits>

namespace culld {

/// a + b = sum + error exactly, unless the sum overflows (then error is NaN).
struct TwoSum {
  double sum, error;
};
inline TwoSum twoSum(double a, double b) noexcept {
  const double sum = a + b;
  const double b_part = sum - a;
  const double a_part = sum - b_part;
  return {sum, (a - a_part) + (b - b_part)};
}

/// Largest double of the two next to a + b that is <= a + b exactly.
inline double addDown(double a, double b) noexcept {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  const TwoSum s = twoSum(a, b);
  if (s.sum == kInf) return std::numeric_limits<double>::max();
  return s.error < 0.0 ? std::nextafter(s.sum, -kInf) : s.sum;
}
inline double addUp(double a, double b) noexcept { return -addDown(-a, -b); }

/// A float f, as near as rounding allows, with origin + f <= x exactly.
inline float offsetDown(double x, double origin) noexcept {
  constexpr float kMax = std::numeric_limits<float>::max();
  constexpr float kInf = std::numeric_limits<float>::infinity();
  const TwoSum s = twoSum(x, -origin);
  if (s.sum >= static_cast<double>(kMax)) return kMax;
  if (s.sum < -static_cast<double>(kMax)) return -kInf;
  const float f = static_cast<float>(s.sum);
  // f is a double too, and rounding is monotone: f < sum implies f <= the exact difference.
  const bool too_large =
      static_cast<double>(f) > s.sum || (static_cast<double>(f) == s.sum && s.error < 0.0);
  return too_large ? std::nextafter(f, -kInf) : f;
}
inline float offsetUp(double x, double origin) noexcept { return -offsetDown(-x, -origin); }

}  // namespace culld
