// The box of an object's mesh where the object stands: tighter than its bounds in the world if it
// is turned. And the sphere around it, which is asked first.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "culling/scene/scene_snapshot.h"

namespace culld {

/// centre +- half[0] +- half[1] +- half[2], all known to a few units of `reach`.
struct OrientedBox {
  glm::dvec3 centre;
  std::array<glm::dvec3, 3> half;
  double radius;  ///< of the sphere around it
  double reach;   ///< of all terms that its numbers are sums of
};

/// Is the box of the mesh in general tighter than the object's bounds?
inline bool turned(const std::array<double, 12>& m) noexcept {
  return m[1] != 0.0 || m[2] != 0.0 || m[4] != 0.0 || m[6] != 0.0 || m[8] != 0.0 || m[9] != 0.0;
}

inline OrientedBox orientedBox(const std::array<double, 12>& m, const Box& box) noexcept {
  const glm::dvec3 middle = 0.5 * box.min + 0.5 * box.max;
  OrientedBox out;
  out.centre = toWorld(m, middle);
  out.reach = std::abs(m[3]) + std::abs(m[7]) + std::abs(m[11]);
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<int>(i);
    const double side = std::max(box.max[axis] - middle[axis], middle[axis] - box.min[axis]);
    out.half[i] = side * glm::dvec3(m[i], m[4 + i], m[8 + i]);
    const double column = std::abs(m[i]) + std::abs(m[4 + i]) + std::abs(m[8 + i]);
    out.reach += column * (side + std::abs(middle[axis]));
  }
  const auto& [a, b, c] = out.half;
  out.radius = std::max({glm::length(a + b + c), glm::length(a + b - c), glm::length(a - b + c),
                         glm::length(a - b - c)});
  return out;
}

}  // namespace culld
