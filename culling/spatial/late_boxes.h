// Prepared boxes whose volumes are refreshed late: objects that move wait beside the tree, and are
// asked one by one, until there are so many that refitting nodes for all of them at once pays.
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
      : boxes_(std::move(boxes)), most_waiting_(most_waiting) {}

  /// REQUIRES: `next` came from this snapshot by edits of the objects in `changed`.
  /// ERROR: as PreparedBoxes.
  Result<LateBoxes> edited(SnapshotPtr next, std::span<const ObjectId> changed) const;

  /// As they were when they were refreshed last.
  const PreparedBoxes& boxes() const noexcept { return boxes_; }
  /// Ascending: where they are in boxes() is out of date.
  std::span<const ObjectId> waiting() const noexcept { return waiting_; }

  /// What a walk of boxes() found becomes what the frustum may hold now. Returns how many live
  /// objects have a bound now.
  std::size_t bringUpToDate(const Camera& camera, std::vector<ObjectId>& found,
                            FrustumWalkStats& stats) const;

 private:
  bool mayWait(const SceneSnapshot& next, ObjectId id) const;

  PreparedBoxes boxes_;
  std::size_t most_waiting_;
  SnapshotPtr scene_;  ///< where those that wait are; none if none do
  std::vector<ObjectId> waiting_;
};

}  // namespace culld
