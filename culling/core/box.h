// Axis-aligned boxes in double precision, world space unless a name says otherwise.
#pragma once
#include <algorithm>
#include <cmath>
#include <glm/vec3.hpp>
#include <limits>

namespace culld {

struct Box {
  glm::dvec3 min{std::numeric_limits<double>::infinity()};
  glm::dvec3 max{-std::numeric_limits<double>::infinity()};

  bool empty() const noexcept {
    return !(min.x <= max.x && min.y <= max.y && min.z <= max.z);  // a NaN box is empty too
  }
  bool finite() const noexcept {
    return std::isfinite(min.x) && std::isfinite(min.y) && std::isfinite(min.z) &&
           std::isfinite(max.x) && std::isfinite(max.y) && std::isfinite(max.z);
  }
  void grow(const glm::dvec3& p) noexcept {
    min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
    max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
  }
  void grow(const Box& b) noexcept {
    if (b.empty()) return;
    grow(b.min);
    grow(b.max);
  }
  bool operator==(const Box&) const = default;
};

/// Half the surface; 0 for an empty box.
inline double halfArea(const Box& b) noexcept {
  if (b.empty()) return 0.0;
  const glm::dvec3 d = b.max - b.min;
  return d.x * d.y + d.y * d.z + d.z * d.x;
}

}  // namespace culld
