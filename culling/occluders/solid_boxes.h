// Large boxes that fill a set of voxels, overlapping: each cannot grow in any direction.
#pragma once
#include <cstddef>
#include <vector>

#include "culling/spatial/voxel_grid.h"

namespace culld {

/// Boxes of voxels of `solid`, the largest faces first, at most `most`. Every voxel is in one of
/// those found, unless that takes too long. COST: a second at most.
std::vector<VoxelRange> solidBoxes(const VoxelGrid& grid, const VoxelBits& solid, std::size_t most);

}  // namespace culld
