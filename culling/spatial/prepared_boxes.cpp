#include "culling/spatial/prepared_boxes.h"

#include <utility>

#include "culling/spatial/frustum_walk.h"

namespace culld {

PreparedBoxes::PreparedBoxes(SnapshotPtr scene, WideBvh bvh)
    : scene_(std::move(scene)), bvh_(std::make_shared<const WideBvh>(std::move(bvh))) {}

Result<PreparedBoxes> PreparedBoxes::of(SnapshotPtr scene) {
  if (auto fits = WideBvh::fits(*scene); !fits) return std::move(fits).error();
  WideBvh bvh = WideBvh::of(*scene);
  return PreparedBoxes(std::move(scene), std::move(bvh));
}

Result<PreparedBoxes> PreparedBoxes::edited(SnapshotPtr next,
                                            std::span<const ObjectId> changed) const {
  if (auto fits = WideBvh::fits(*next); !fits) return std::move(fits).error();
  WideBvh bvh = bvh_->edited(*next, changed);
  return PreparedBoxes(std::move(next), std::move(bvh));
}

void PreparedBoxes::completeIds(std::vector<ObjectId>& ids) const {
  const auto always = bvh_->alwaysKept();
  ids.insert(ids.end(), always.begin(), always.end());
  sortIds(ids, scene_->objectCount());
}

}  // namespace culld
