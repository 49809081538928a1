// Prepared boxes whose volumes are refreshed late: objects that move wait beside the tree, and are
// asked eight at a time, until there are so many that refitting nodes for all of them at once pays.
// What waits is asked by its bounds alone, whatever a walk of the tree asks of the others.
#pragma once
#include <span>
#include <vector>

#include "culling/core/camera.h"
#include "culling/spatial/frustum_walk.h"
#include "culling/spatial/prepared_boxes.h"

namespace culld {

class LateBoxes {
 public:
  /// `most_waiting`: 0 refreshes with every edit.
  LateBoxes(PreparedBoxes boxes, std::size_t most_waiting)
      : boxes_(std::move(boxes)), most_waiting_(most_waiting), scene_(boxes_.scene()) {}

  /// REQUIRES: `next` came from this snapshot by edits of the objects in `changed`.
  /// ERROR: as PreparedBoxes.
  Result<LateBoxes> edited(SnapshotPtr next, std::span<const ObjectId> changed) const;

  /// As they were when they were refreshed last.
  const PreparedBoxes& boxes() const noexcept { return boxes_; }
  /// As it is now.
  const SnapshotPtr& scene() const noexcept { return scene_; }
  std::size_t bytes() const noexcept {
    return boxes_.bytes() + waiting_.capacity() * sizeof(ObjectId) +
           bits_.capacity() * sizeof(std::uint64_t);
  }
  /// Ascending: where they are in boxes() is out of date.
  std::span<const ObjectId> waiting() const noexcept { return waiting_; }

  /// What a walk of boxes() found becomes what the frustum may hold now. Returns how many live
  /// objects have a bound now.
  std::size_t bringUpToDate(const Camera& camera, std::vector<ObjectId>& found,
                            FrustumWalkStats& stats) const;

 private:
  bool mayWait(const SceneSnapshot& next, ObjectId id) const;
  bool waits(ObjectId id) const noexcept { return (bits_[id / 64] >> (id % 64) & 1U) != 0; }

  PreparedBoxes boxes_;
  std::size_t most_waiting_;
  SnapshotPtr scene_;
  std::vector<ObjectId> waiting_;
  std::vector<std::uint64_t> bits_;  ///< of waiting_, by object of boxes(); empty if none waits
};

}  // namespace culld
