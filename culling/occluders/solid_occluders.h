// What a scene's closed parts hide, as a few boxes: voxels proven solid, filled with large boxes
// that are drawn instead of the walls they lie in. A box blocks nothing that the walls around it do
// not, for every eye that stands clear of them (docs/error-model/solids.md).
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "culling/core/box.h"
#include "culling/core/ids.h"
#include "culling/occluders/occluder_set.h"
#include "culling/occluders/strict_solids.h"
#include "culling/occluders/voxel_planes.h"
#include "culling/scene/scene_snapshot.h"
#include "culling/spatial/prepared_boxes.h"

namespace culld {

struct SolidLimits {
  VoxelLimits voxels{};
  std::uint64_t most_work = 400'000'000;  ///< boxes and rows looked at, some ns each
  std::size_t most_boxes = 4096;
};

class SolidOccluders {
 public:
  /// ERROR: as PreparedBoxes::of.
  static Result<SolidOccluders> of(const SceneSnapshot& scene, const SolidLimits& limits);
  /// For the scene after an edit of `changed`: without all that rested on these objects. Boxes are
  /// only dropped; of() finds new ones.
  Result<SolidOccluders> without(std::span<const ObjectId> changed) const;

  std::size_t size() const noexcept { return boxes_.size(); }
  /// World bounds of box i, which is object i of drawn().
  const Box& box(std::size_t i) const noexcept { return boxes_[i]; }
  /// The boxes as a scene of their own, of cubes, to be walked and drawn like any other.
  const PreparedBoxes& drawn() const noexcept { return *drawn_; }
  const OccluderSet& occluders() const noexcept { return *occluders_; }
  /// True: an eye anywhere in there is outside of all that the boxes stand for, and so is the way
  /// to any other place in there.
  bool clear(const Box& world) const noexcept;
  std::size_t bytes() const noexcept;

 private:
  struct Baked {
    VoxelGrid grid;
    VoxelBits not_clear;
    std::vector<SolidMaker> makers;
    double snap;
  };
  SolidOccluders() = default;
  Result<SolidOccluders> made(std::vector<VoxelRange> ranges) const;

  std::shared_ptr<const Baked> baked_;
  std::vector<VoxelRange> ranges_;
  std::vector<Box> boxes_;
  std::shared_ptr<const PreparedBoxes> drawn_;
  std::shared_ptr<const OccluderSet> occluders_;
};

}  // namespace culld
