// Where a scene is to be cut into voxels: along the walls of its solids first, evenly in between.
#pragma once
#include <cstdint>

#include "culling/occluders/solid_parts.h"
#include "culling/spatial/voxel_grid.h"

namespace culld {

struct VoxelLimits {
  std::uint64_t most_voxels = std::uint64_t{1} << 23U;
  std::uint32_t most_wall_planes = 160;  ///< per axis
  std::uint32_t even_voxels = 192;       ///< along the longest side, before walls are added
  /// Few triangles are not worth many voxels: so many each, but not less than `few_voxels`.
  std::uint64_t voxels_per_triangle = 2048, few_voxels = std::uint64_t{1} << 18U;
};

/// What a coordinate may be off without being told apart: rounding, of the largest coordinate.
double voxelSnap(const Box& world) noexcept;

/// A grid around `world`. The planes of axis-parallel faces of `parts`, those of the largest total
/// area, are planes of it. REQUIRES: a finite box that is not empty.
VoxelGrid voxelGridFor(const SolidParts& parts, const Box& world, const VoxelLimits& limits);

}  // namespace culld
