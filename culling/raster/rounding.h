// Double to float with a known direction.
#pragma once
#include <cmath>
#include <limits>

namespace culld {

/// Largest float <= x; lowest float for anything below it (NaN too: callers reject NaN first).
inline float floatDown(double x) noexcept {
  constexpr float kHighest = std::numeric_limits<float>::max();
  if (!(x >= -static_cast<double>(kHighest))) return -std::numeric_limits<float>::infinity();
  if (x >= static_cast<double>(kHighest)) return kHighest;
  const float f = static_cast<float>(x);
  return static_cast<double>(f) <= x ? f
                                     : std::nextafterf(f, -std::numeric_limits<float>::infinity());
}

/// Smallest float >= x; +infinity for NaN.
inline float floatUp(double x) noexcept { return -floatDown(-x); }

}  // namespace culld
