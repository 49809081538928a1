// How near the plane of a triangle gets, over the image: for asking what lies on it or behind it.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "culling/raster/rounding.h"
#include "culling/raster/triangle_setup.h"

namespace culld {

/// Nearness over the image is at most a * u + b * v + c, at most `ceiling`, and never asked for
/// below 0.
struct NearestPlane {
  double a = 0.0, b = 0.0, c = std::numeric_limits<double>::infinity();
  float ceiling = std::numeric_limits<float>::infinity();

  /// Over the places [u0, u1] x [v0, v1] of the image, none of them negative; rounded nearer.
  float over(double u0, double u1, double v0, double v1) const noexcept {
    const double near = c + a * (a > 0.0 ? u1 : u0) + b * (b > 0.0 ? v1 : v0);
    const double terms = std::abs(c) + std::abs(a) * u1 + std::abs(b) * v1;
    return std::max(std::min(floatUp(near + 0x1p-48 * terms), ceiling), 0.0F);
  }
};

/// The bound of docs/error-model.md §5.2: the numerator's upper bound over the determinant's least
/// size. REQUIRES: `t` made from the same arguments, its orientation not 0.
NearestPlane nearestPlane(const std::array<CellVertex, 3>& p, const CellVertexError& e,
                          const GridSize& g, const OrientedTriangle& t, float ceiling) noexcept;

}  // namespace culld
