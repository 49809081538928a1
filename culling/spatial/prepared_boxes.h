// The boxes of one snapshot, ready for walks: what every method that culls with boxes prepares,
// edits and appends in the same way. Copies share the boxes.
#pragma once
#include <memory>
#include <span>
#include <vector>

#include "culling/core/result.h"
#include "culling/scene/scene_snapshot.h"
#include "culling/spatial/wide_bvh.h"

namespace culld {

class PreparedBoxes {
 public:
  /// ERROR: as WideBvh::fits.
  static Result<PreparedBoxes> of(SnapshotPtr scene);
  /// REQUIRES: `next` came from this snapshot by edits of the objects in `changed`. ERROR: as of().
  Result<PreparedBoxes> edited(SnapshotPtr next, std::span<const ObjectId> changed) const;

  const SnapshotPtr& scene() const noexcept { return scene_; }
  const WideBvh& bvh() const noexcept { return *bvh_; }
  std::size_t bytes() const noexcept { return bvh_->bytes(); }

  /// Completes what a walk found to an answer: the objects without a bound too, all ascending.
  void completeIds(std::vector<ObjectId>& ids) const;

 private:
  PreparedBoxes(SnapshotPtr scene, WideBvh bvh);

  SnapshotPtr scene_;
  std::shared_ptr<const WideBvh> bvh_;
};

/// A culler that can lend its boxes to another method's culler of the same snapshot.
class HoldsBoxes {
 public:
  virtual ~HoldsBoxes() = default;
  /// nullptr if they are not of the culler's snapshot.
  virtual const PreparedBoxes* boxes() const noexcept = 0;
};

}  // namespace culld
