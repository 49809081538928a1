// Voxels that are proven to lie inside the closed parts of a scene: whatever sight enters them has
// met a blocking surface before. docs/error-model/solids.md proves it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "culling/core/ids.h"
#include "culling/occluders/solid_parts.h"
#include "culling/spatial/voxel_grid.h"

namespace culld {

/// An object that made voxels solid, and where.
struct SolidMaker {
  ObjectId object;
  VoxelRange range;
};

struct SolidVoxels {
  VoxelBits solid;
  /// Here a surface of a maker may be, or it was not decided whether this is inside of one. An eye
  /// that stands clear of these and of the solid ones is outside of all makers.
  VoxelBits unclear;
  std::vector<SolidMaker> makers;  ///< by object, a range for each part
  bool complete = true;            ///< false: the work's limit was reached, parts were left out
};

/// `most_work`: boxes and rows looked at. REQUIRES: `snap` is voxelSnap of the grid's scene.
SolidVoxels strictSolids(const SolidParts& parts, const VoxelGrid& grid, double snap,
                         std::uint64_t most_work);

}  // namespace culld
