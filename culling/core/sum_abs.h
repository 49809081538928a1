// The size of a vector that bounds of rounding errors are made of.
#pragma once
#include <cmath>
#include <glm/vec3.hpp>

namespace culld {

inline double sumAbs(const glm::dvec3& v) noexcept {
  return std::abs(v.x) + std::abs(v.y) + std::abs(v.z);
}

}  // namespace culld
