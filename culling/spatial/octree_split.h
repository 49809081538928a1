// How an octree's planes divide boxes; shared by building and editing.
#pragma once
#include <algorithm>
#include <cstdint>

#include "culling/core/box.h"
#include "culling/spatial/octree.h"

namespace culld {

/// Bit o: the box reaches into octant o. What lies on a plane is in the octant beyond it.
inline std::uint32_t octantsOf(const Box& box, const glm::dvec3& centre) noexcept {
  std::uint32_t octants = 0xFFU;
  constexpr std::uint32_t kNear[3] = {0x55U, 0x33U, 0x0FU};
  for (int axis = 0; axis < 3; ++axis) {
    const bool near = box.min[axis] < centre[axis], far = !(box.max[axis] < centre[axis]);
    if (!near) octants &= ~kNear[axis];
    if (!far) octants &= kNear[axis];
  }
  return octants;
}

/// The part of `box` in an octant: closed, so that the parts make up the box.
inline Box partIn(const Box& box, const glm::dvec3& centre, std::uint32_t octant) noexcept {
  Box part = box;
  for (int axis = 0; axis < 3; ++axis) {
    if ((octant >> axis & 1U) != 0) {
      part.min[axis] = std::max(part.min[axis], centre[axis]);
    } else {
      part.max[axis] = std::min(part.max[axis], centre[axis]);
    }
  }
  return part;
}

inline double longestSide(const Box& box) noexcept {
  return std::max({box.max.x - box.min.x, box.max.y - box.min.y, box.max.z - box.min.z});
}

/// Does an object of these bounds go down into all octants that it touches?
inline bool smallIn(const Box& bounds, double half_m, const OctreeRules& rules) noexcept {
  return longestSide(bounds) < rules.small_share * half_m;
}

}  // namespace culld
