#include "culling/spatial/late_boxes.h"

#include <algorithm>
#include <bit>
#include <iterator>
#include <utility>

#include "culling/spatial/wide_bvh_fit.h"

namespace culld {
namespace {

bool live(const Instance& instance) {
  return instance.active() && laneClassOf(instance) == LaneClass::kLane;
}

}  // namespace

/// Objects that are new, or have no bound, go into the tree's lists at once.
bool LateBoxes::mayWait(const SceneSnapshot& next, ObjectId id) const {
  const auto kept = boxes_.bvh().alwaysKept();
  return id < boxes_.scene()->objectCount() && !std::binary_search(kept.begin(), kept.end(), id) &&
         laneClassOf(next.instance(id)) != LaneClass::kAlwaysKept;
}

Result<LateBoxes> LateBoxes::edited(SnapshotPtr next, std::span<const ObjectId> changed) const {
  std::vector<ObjectId> all;
  std::set_union(waiting_.begin(), waiting_.end(), changed.begin(), changed.end(),
                 std::back_inserter(all));
  const bool late =
      all.size() <= most_waiting_ &&
      std::all_of(changed.begin(), changed.end(), [&](ObjectId id) { return mayWait(*next, id); });
  if (late) {
    LateBoxes waits = *this;
    waits.scene_ = std::move(next);
    waits.waiting_ = std::move(all);
    waits.bits_.resize(boxes_.scene()->objectCount() / 64 + 1);
    for (const ObjectId id : changed) waits.bits_[id / 64] |= std::uint64_t{1} << (id % 64);
    return waits;
  }
  auto refreshed = boxes_.edited(std::move(next), all);
  if (!refreshed) return std::move(refreshed).error();
  return LateBoxes(std::move(refreshed).value(), most_waiting_);
}

std::size_t LateBoxes::bringUpToDate(const Camera& camera, std::vector<ObjectId>& found,
                                     FrustumWalkStats& stats) const {
  std::size_t live_now = boxes_.bvh().liveObjects();
  if (waiting_.empty()) return live_now;
  std::size_t left = 0;
  for (const ObjectId id : found) {  // without a branch: which ones wait is no pattern
    found[left] = id;
    left += waits(id) ? 0U : 1U;
  }
  found.resize(left);
  std::vector<ObjectId> there;
  Box everything;
  for (const ObjectId id : waiting_) {
    live_now -= live(boxes_.scene()->instance(id)) ? 1U : 0U;
    if (!live(scene_->instance(id))) continue;
    ++live_now;
    there.push_back(id);
    everything.grow(scene_->instance(id).bounds_world);
  }
  const FrustumTest frustum(camera, everything);
  for (std::size_t first = 0; first < there.size(); first += kWideLanes) {
    WideNode node = emptyNode();
    const std::size_t count = std::min(kWideLanes, there.size() - first);
    for (std::size_t l = 0; l < count; ++l) node.child[l] = ChildRef::object(there[first + l]);
    fitNode(node, *scene_, [&](std::uint32_t) -> const WideNode& { return node; });
    ++stats.nodes_visited;
    stats.tested += static_cast<std::uint32_t>(count);
    stats.plane_tests += count * static_cast<std::size_t>(std::popcount(frustum.planes()));
    const LaneVerdicts verdicts = frustum.test(node, frustum.planes());
    for (std::uint32_t lanes = verdicts.may_intersect; lanes != 0; lanes &= lanes - 1) {
      found.push_back(there[first + static_cast<std::size_t>(std::countr_zero(lanes))]);
    }
  }
  return live_now;
}

}  // namespace culld
