// The convex hull of points, by Qhull (Barber, Dobkin, Huhdanpaa 1996). Points that are nearly in
// one plane are joggled for the computation only: the hull's corners are always the points given.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

namespace culld {

struct ConvexHull {
  std::vector<std::uint32_t> corners;  ///< indices of points, ascending
  /// Indices of points, CCW from outside. Closed: each edge is run along once each way.
  std::vector<std::array<std::uint32_t, 3>> triangles;
  bool empty() const noexcept { return triangles.empty(); }
};

/// Empty for points that are flat, too few or not finite. That it is convex, and holds all points,
/// is so up to rounding: who needs it for certain checks it. THREADS: any.
ConvexHull convexHull(std::span<const glm::dvec3> points);

}  // namespace culld
