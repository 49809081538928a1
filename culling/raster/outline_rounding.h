// What sides and planes of an outline may lose on their way from doubles to floats, and to which
// side they are rounded. docs/error-model.md §4.6 and docs/error-model/gpu.md §2 prove it.
#pragma once
#include <algorithm>
#include <cmath>

#include "culling/raster/triangle_setup.h"

namespace culld {

/// A float >= x, for x within a float's range.
inline float roundedUp(double x) noexcept { return static_cast<float>(x + 0x1p-22 * std::abs(x)); }

/// The least change of a * i + b * j from the lower corner of a cell to anywhere in it.
template <typename Line>
double leastChange(const Line& line) noexcept {
  return std::min(line.a, 0.0) + std::min(line.b, 0.0);
}

/// Of a side of that value at some corner: its own error, and four times what floats lose within
/// `extent` cells of there.
inline double sideMargin(const SideLine& side, double value, double extent) noexcept {
  return side.error + 0x1p-20 * (std::abs(value) + extent);
}

/// Of a plane, by the sum of its terms' sizes. Larger terms would come too near overflow.
inline constexpr double kMostPlaneTerms = 1e37;
inline double planeSlack(double terms) noexcept { return 0x1p-20 * terms + 1e-37; }

}  // namespace culld
