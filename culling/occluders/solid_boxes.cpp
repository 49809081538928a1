#include "culling/occluders/solid_boxes.h"

#include <algorithm>
#include <array>
#include <bit>

namespace culld {
namespace {

/// The orders in which a box may grow along the axes.
constexpr std::size_t kOrders[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2},
                                       {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};

/// Its largest face: what it can hide.
double faceOf(const VoxelGrid& grid, const VoxelRange& range) {
  const Box box = grid.boundsOf(range);
  const glm::dvec3 d = box.max - box.min;
  return std::max({d.x * d.y, d.y * d.z, d.z * d.x});
}

constexpr std::uint64_t kMostWork = 30'000'000;  ///< words of bits looked at, about

std::uint64_t wordsOf(const VoxelRange& range) {
  return range.size() / (range.last[0] - range.first[0]) *
         ((range.last[0] - range.first[0]) / VoxelBits::kWordBits + 1);
}

/// As far as it goes along an axis, both ways. Returns the work.
std::uint64_t grow(VoxelRange& range, std::size_t axis, const VoxelBits& solid) {
  std::uint64_t work = 0;
  VoxelRange slab = range;
  while (range.first[axis] > 0) {
    slab.first[axis] = range.first[axis] - 1;
    slab.last[axis] = range.first[axis];
    work += wordsOf(slab);
    if (!solid.every(slab)) break;
    --range.first[axis];
  }
  while (range.last[axis] < solid.counts()[axis]) {
    slab.first[axis] = range.last[axis];
    slab.last[axis] = range.last[axis] + 1;
    work += wordsOf(slab);
    if (!solid.every(slab)) break;
    ++range.last[axis];
  }
  return work;
}

VoxelRange largestAround(const Voxel& seed, const VoxelGrid& grid, const VoxelBits& solid,
                         std::uint64_t& work) {
  VoxelRange best;
  double most = -1.0;
  for (const auto& order : kOrders) {
    VoxelRange range{seed, {seed[0] + 1, seed[1] + 1, seed[2] + 1}};
    for (const std::size_t axis : order) work += grow(range, axis, solid);
    const double face = faceOf(grid, range);
    if (face > most) {
      most = face;
      best = range;
    }
  }
  return best;
}

}  // namespace

std::vector<VoxelRange> solidBoxes(const VoxelGrid& grid, const VoxelBits& solid,
                                   std::size_t most) {
  std::vector<VoxelRange> boxes;
  VoxelBits left = solid;
  std::uint64_t work = 0;
  for (std::uint32_t z = 0; z < solid.counts()[2]; ++z) {
    for (std::uint32_t y = 0; y < solid.counts()[1]; ++y) {
      for (std::uint32_t w = 0; w < solid.wordsPerRow(); ++w) {
        while (left.row(y, z)[w] != 0 && work < kMostWork) {
          const auto bit = static_cast<std::uint32_t>(std::countr_zero(left.row(y, z)[w]));
          boxes.push_back(largestAround({w * VoxelBits::kWordBits + bit, y, z}, grid, solid, work));
          left.clear(boxes.back());
        }
      }
    }
  }
  std::stable_sort(boxes.begin(), boxes.end(), [&](const VoxelRange& a, const VoxelRange& b) {
    return faceOf(grid, a) > faceOf(grid, b);
  });
  if (boxes.size() > most) boxes.resize(most);
  return boxes;
}

}  // namespace culld
