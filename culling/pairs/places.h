// Viewers and targets of a question about pairs: boxes of world space, of one point or more.
#pragma once
#include <array>
#include <cstddef>
#include <glm/vec3.hpp>

#include "culling/core/box.h"

namespace culld {

/// Coordinates and radii are below this: products of three of them and their differences are
/// finite.
inline constexpr double kFarthestPlace = 1e90;

/// Somewhere in `box`, and from there up to `radius_m` away.
struct Place {
  Box box;                ///< world space, metres; min == max for a point
  double radius_m = 0.0;  ///< motion bound
};

/// The place with its motion, as the corners of one box.
struct PlaceCorners {
  std::array<glm::dvec3, 8> corner;
  std::size_t count = 8;  ///< 1 for a point that stands still
  glm::dvec3 centre{0.0};
  double largest = 0.0;  ///< of |x|, |y|, |z| over the corners
};

/// GUARANTEES: contains all of the place. REQUIRES: a finite, non-empty box and a radius >= 0.
PlaceCorners cornersOf(const Place& place) noexcept;

}  // namespace culld
