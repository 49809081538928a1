// Which voxels does a triangle pass through? Outer-conservative: a voxel is left out only if its
// inside is surely clear of the triangle (separating axes, Akenine-Moller 2001; the margins are
// proven in docs/error-model/solids.md §2).
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>

#include "culling/core/box.h"
#include "culling/spatial/voxel_grid.h"

namespace culld {

using WorldTriangle = std::array<glm::dvec3, 3>;

/// True: no point of the triangle lies inside the box; on its rim there may be some, so that a wall
/// in exactly the plane of a box's face does not reach into it. NaN is never clear.
bool clearOfInside(const WorldTriangle& triangle, const Box& box) noexcept;

/// Sets the bits of all voxels of `range` whose inside the triangle may reach. `range` is counted
/// from the grid's first voxel, bits from the range's. Returns the boxes that were tested.
/// COST: O(voxels reached * log).
std::uint64_t markVoxels(const WorldTriangle& triangle, const VoxelGrid& grid,
                         const VoxelRange& range, VoxelBits& bits);

}  // namespace culld
