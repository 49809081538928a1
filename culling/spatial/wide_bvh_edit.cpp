// Edits: an object that stays within its node's box is refitted in place, any other is taken out
// and put in again where it costs the least area. Node 0 stays the root; a node left with one child
// gives its place to that child, so a path never gets longer by removals.
#include <algorithm>
#include <bit>
#include <cstring>

#include "culling/spatial/wide_bvh.h"
#include "culling/spatial/wide_bvh_fit.h"

namespace culld {
namespace {

constexpr auto kLanes = static_cast<std::uint32_t>(kWideLanes);

bool contains(const Box& outer, const Box& inner) {
  return outer.min.x <= inner.min.x && outer.min.y <= inner.min.y && outer.min.z <= inner.min.z &&
         outer.max.x >= inner.max.x && outer.max.y >= inner.max.y && outer.max.z >= inner.max.z;
}

/// Near enough for choosing a lane; not for deciding anything.
Box laneBox(const WideNode& node, std::size_t lane) {
  Box box;
  if ((node.live >> lane & 1U) == 0) return box;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    box.min[axis] = node.origin[a] + static_cast<double>(node.offsets[kMinX + a][lane]);
    box.max[axis] = node.origin[a] + static_cast<double>(node.offsets[kMaxX + a][lane]);
  }
  return box;
}

}  // namespace

class WideBvhEditor {
 public:
  WideBvhEditor(WideBvh& bvh, const SceneSnapshot& next) : bvh_(bvh), next_(next) {}

  void update(ObjectId id) {
    while (bvh_.lane_of_.size() <= id) bvh_.lane_of_.push_back(WideBvh::kNoLane);
    const Instance& instance = next_.instance(id);
    const LaneClass lane_class = laneClassOf(instance);
    setListed(bvh_.always_kept_, id, lane_class == LaneClass::kAlwaysKept && instance.active());
    const std::uint32_t lane = bvh_.lane_of_[id];
    if (lane_class != LaneClass::kLane) {
      if (lane != WideBvh::kNoLane) remove(id);
    } else if (lane == WideBvh::kNoLane) {
      insert(id);
    } else if (mayStay(lane, instance)) {
      refitUpwards(lane / kLanes);
    } else {
      remove(id);
      insert(id);
    }
    ++bvh_.edits_since_build_;
  }

 private:
  /// A hidden object keeps its lane; shown again it may find its node shrunk, so it is compared
  /// with the box one level up.
  bool mayStay(std::uint32_t lane, const Instance& instance) const {
    if (!instance.active()) return true;
    std::uint32_t index = lane / kLanes;
    const bool was_live = (bvh_.nodes_[index].live >> (lane % kLanes) & 1U) != 0;
    if (!was_live && bvh_.parentOf(index) != WideBvh::kNoLane) {
      index = bvh_.parentOf(index) / kLanes;
    }
    return bvh_.parentOf(index) == WideBvh::kNoLane ||
           contains(boundsOf(bvh_.nodes_[index]), instance.bounds_world);
  }

  WideNode& change(std::uint32_t index) { return bvh_.nodes_.mutableAt(index); }

  /// Fits the node and everything above it, up to the first node that does not change.
  void refitUpwards(std::uint32_t index) {
    while (true) {
      const WideNode& old = bvh_.nodes_[index];
      WideNode node = old;
      fitNode(node, next_, [this](std::uint32_t i) -> const WideNode& { return bvh_.nodes_[i]; });
      if (std::memcmp(&node, &old, sizeof(WideNode)) == 0 && index != first_dirty_) return;
      change(index) = node;
      if (index == first_dirty_) first_dirty_ = WideBvh::kNoLane;
      if (bvh_.parentOf(index) == WideBvh::kNoLane) return;
      index = bvh_.parentOf(index) / kLanes;
    }
  }

  /// Puts `child` into a lane and tells the child where it is. Boxes and counts are left to
  /// refitUpwards.
  void setChild(std::uint32_t lane, ChildRef child) {
    WideNode& node = change(lane / kLanes);
    node.child[lane % kLanes] = child;
    if (child.isObject()) bvh_.lane_of_.mutableAt(child.objectId()) = lane;
    if (child.isNode()) bvh_.parent_of_.mutableAt(child.nodeIndex()) = lane;
  }

  /// Empties a lane. Boxes and counts are left to refitUpwards.
  void clearLane(std::uint32_t lane) {
    WideNode& node = change(lane / kLanes);
    node.live = static_cast<std::uint16_t>(node.live & ~(1U << (lane % kLanes)));
    node.child[lane % kLanes] = ChildRef();
  }

  void remove(ObjectId id) {
    const std::uint32_t lane = bvh_.lane_of_[id];
    bvh_.lane_of_.mutableAt(id) = WideBvh::kNoLane;
    --bvh_.lanes_taken_;
    clearLane(lane);
    std::uint32_t index = lane / kLanes;
    while (bvh_.parentOf(index) != WideBvh::kNoLane) {
      const WideNode& node = bvh_.nodes_[index];
      ChildRef last;
      std::uint32_t children = 0;
      for (const ChildRef child : node.child) {
        if (child.empty()) continue;
        last = child;
        ++children;
      }
      if (children > 1) break;
      const std::uint32_t parent_lane = bvh_.parentOf(index);
      if (children == 1) {
        moveUp(index, last, parent_lane);
      } else {
        clearLane(parent_lane);
      }
      release(index);
      index = parent_lane / kLanes;
    }
    refitAlways(index);
  }

  /// The only child of node `index` takes the node's place.
  void moveUp(std::uint32_t index, ChildRef child, std::uint32_t parent_lane) {
    const bool was_live = bvh_.nodes_[index].live != 0;
    setChild(parent_lane, child);
    WideNode& parent = change(parent_lane / kLanes);
    const std::uint32_t bit = 1U << (parent_lane % kLanes);
    parent.live = static_cast<std::uint16_t>(was_live ? parent.live | bit : parent.live & ~bit);
  }

  void release(std::uint32_t index) {
    change(index) = emptyNode();
    bvh_.parent_of_.mutableAt(index) = WideBvh::kNoLane;
    bvh_.free_nodes_.push_back(index);
  }

  std::uint32_t newNode(std::uint32_t parent_lane) {
    if (bvh_.free_nodes_.empty()) {
      bvh_.nodes_.push_back(emptyNode());
      bvh_.parent_of_.push_back(parent_lane);
      return static_cast<std::uint32_t>(bvh_.nodes_.size() - 1);
    }
    const std::uint32_t index = bvh_.free_nodes_.back();
    bvh_.free_nodes_.pop_back();
    change(index) = emptyNode();
    bvh_.parent_of_.mutableAt(index) = parent_lane;
    return index;
  }

  void insert(ObjectId id) {
    ++bvh_.lanes_taken_;
    if (bvh_.empty()) newNode(WideBvh::kNoLane);
    const Box& box = next_.instance(id).bounds_world;
    std::uint32_t index = WideBvh::kRoot;
    for (std::size_t depth = 1;; ++depth) {
      bvh_.deepest_insert_ = std::max(bvh_.deepest_insert_, depth);
      const std::size_t lane = cheapestLane(bvh_.nodes_[index], box);
      const ChildRef there = bvh_.nodes_[index].child[lane];
      const std::uint32_t at = index * kLanes + static_cast<std::uint32_t>(lane);
      if (there.isNode()) {
        index = there.nodeIndex();
        continue;
      }
      if (there.empty()) {
        setChild(at, ChildRef::object(id));
        refitAlways(index);
      } else {
        splitLane(at, there, id);
      }
      return;
    }
  }

  /// The lane whose box grows least by `box`; a free lane if that costs less than growing another.
  static std::size_t cheapestLane(const WideNode& node, const Box& box) {
    std::size_t best = kWideLanes, free_lane = kWideLanes;
    double best_growth = 0.0;
    for (std::size_t l = 0; l < kWideLanes; ++l) {
      if (node.child[l].empty()) {
        free_lane = std::min(free_lane, l);
        continue;
      }
      const Box old = laneBox(node, l);
      Box grown = old;
      grown.grow(box);
      const double growth = halfArea(grown) - halfArea(old);
      if (best == kWideLanes || growth < best_growth) {
        best = l;
        best_growth = growth;
      }
    }
    if (free_lane == kWideLanes) return best;
    const bool descend =
        best != kWideLanes && node.child[best].isNode() && best_growth <= halfArea(box);
    return descend ? best : free_lane;
  }

  /// The object in a full node's lane and the new one become a node of their own.
  void splitLane(std::uint32_t at, ChildRef there, ObjectId id) {
    const std::uint32_t fresh = newNode(at);
    clearLane(at);
    setChild(at, ChildRef::node(fresh));
    setChild(fresh * kLanes, there);
    setChild(fresh * kLanes + 1, ChildRef::object(id));
    refitAlways(fresh);
  }

  /// Fits `index` even if its own bytes come out unchanged: its place in the tree is new.
  void refitAlways(std::uint32_t index) {
    first_dirty_ = index;
    refitUpwards(index);
  }

  WideBvh& bvh_;
  const SceneSnapshot& next_;
  std::uint32_t first_dirty_ = WideBvh::kNoLane;
};

WideBvh WideBvh::edited(const SceneSnapshot& next, std::span<const ObjectId> changed) const {
  if (flat_) return of(next);
  // An edit costs about as much as building 20 objects.
  if (degraded() || (changed.size() > 1024 && changed.size() * 20 > next.objectCount())) {
    return build(next);
  }
  WideBvh bvh = *this;
  WideBvhEditor editor(bvh, next);
  for (const ObjectId id : changed) editor.update(id);
  return bvh;
}

}  // namespace culld
