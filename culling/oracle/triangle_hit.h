// One ray against one triangle, in double precision (T. Moeller, B. Trumbore, 1997), with the two
// answers that a truth about visibility needs: is the surface met, and might it block?
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <optional>

namespace culld::oracle {

using Triangle = std::array<glm::dvec3, 3>;

struct TriangleHit {
  double distance = 0.0;  ///< along the unit direction; negative behind the origin
  bool met = false;       ///< inside the triangle itself; else only inside its grown rim
  bool front = false;     ///< seen from the counter-clockwise side
};

/// The triangle's rim is grown by `grow` (seen along the ray) for the answer "might block": the
/// crack of a T-junction is as wide as the rounding of coordinates, and nobody is asked to see
/// through it. REQUIRES: unit direction. Edge-on and degenerate triangles are not met.
inline std::optional<TriangleHit> hitTriangle(const glm::dvec3& origin, const glm::dvec3& direction,
                                              const Triangle& corner, double grow) {
  constexpr double kEdgeOn = 1e-12;   // cosine: beyond it the facing is rounding noise
  constexpr double kRounding = 1e-9;  // of barycentric coordinates
  constexpr double kMaxGrow = 0.5;    // slivers may not grow beyond their own size
  const glm::dvec3 e1 = corner[1] - corner[0];
  const glm::dvec3 e2 = corner[2] - corner[0];
  const glm::dvec3 p = glm::cross(direction, e2);
  const double det = glm::dot(e1, p);
  const glm::dvec3 from_corner = origin - corner[0];
  const double u = glm::dot(from_corner, p) / det;
  const glm::dvec3 q = glm::cross(from_corner, e1);
  const double v = glm::dot(direction, q) / det;
  const double w = 1.0 - u - v;
  if (!(std::min({u, v, w}) > -kMaxGrow)) return std::nullopt;  // NaN: degenerate
  const double size = std::abs(det);
  if (!(size > kEdgeOn * glm::length(glm::cross(e1, e2)))) return std::nullopt;
  const TriangleHit hit{glm::dot(e2, q) / det, std::min({u, v, w}) >= 0.0, det > 0.0};
  if (hit.met) return hit;
  const auto rim = [&](const glm::dvec3& edge) {
    return -std::min(kMaxGrow, kRounding + grow * glm::length(edge) / size);
  };
  if (u < rim(e2) || v < rim(e1) || w < rim(e2 - e1)) return std::nullopt;
  return hit;
}

}  // namespace culld::oracle
