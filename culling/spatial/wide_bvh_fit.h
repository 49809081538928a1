// How one node is computed from what lies below it; shared by building and editing, so that a tree
// has the same exact containment however it came about.
#pragma once
#include "culling/core/box.h"
#include "culling/scene/scene_snapshot.h"
#include "culling/spatial/wide_bvh.h"

namespace culld {

enum class LaneClass {
  kNone,        ///< removed, or nothing in it to see: neither in the tree nor in answers
  kAlwaysKept,  ///< no bound holds for it: not in the tree
  kLane,        ///< in the tree; live if the object is active
};
LaneClass laneClassOf(const Instance& instance) noexcept;

WideNode emptyNode() noexcept;

/// Contains every live lane of the node exactly; empty if no lane is live.
Box boundsOf(const WideNode& node) noexcept;

/// Contains what the lane does; empty if it is not live.
Box boundsOfLane(const WideNode& node, std::size_t lane) noexcept;

/// Has an ascending list hold an id, or not.
void setListed(std::vector<ObjectId>& list, ObjectId id, bool wanted);

/// Sets everything but the children of the node from its children. `node_at(index)` gives
/// a child node, which is fitted already.
template <typename NodeAt>
void fitNode(WideNode& node, const SceneSnapshot& scene, const NodeAt& node_at);

/// Origin, offsets and live bits from the boxes of the lanes; an empty box makes a lane that is not
/// live.
void fitNode(WideNode& node, const Box (&boxes)[kWideLanes]) noexcept;

template <typename NodeAt>
void fitNode(WideNode& node, const SceneSnapshot& scene, const NodeAt& node_at) {
  Box boxes[kWideLanes];
  std::uint32_t live_objects = 0, blocking = 0;
  for (std::size_t l = 0; l < kWideLanes; ++l) {
    const ChildRef child = node.child[l];
    if (child.isObject()) {
      const Instance& instance = scene.instance(child.objectId());
      if (instance.active() && laneClassOf(instance) == LaneClass::kLane) {
        boxes[l] = instance.bounds_world;
        ++live_objects;
        blocking |= (scene.mesh(instance.mesh).blocking_triangles != 0 ? 1U : 0U) << l;
      }
    } else if (!child.empty()) {
      const WideNode& below = node_at(child.nodeIndex());
      boxes[l] = boundsOf(below);
      live_objects += below.live_objects;
      blocking |= (below.blocking != 0 ? 1U : 0U) << l;
    }
  }
  fitNode(node, boxes);
  node.live_objects = live_objects;
  node.blocking = static_cast<std::uint16_t>(blocking);
}

}  // namespace culld
