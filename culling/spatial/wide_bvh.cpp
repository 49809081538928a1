#include "culling/spatial/wide_bvh.h"

#include <limits>
#include <string>

#include "culling/spatial/outward.h"
#include "culling/spatial/wide_bvh_fit.h"

namespace culld {

LaneClass laneClassOf(const Instance& instance) noexcept {
  if (instance.removed) return LaneClass::kNone;
  const Box& b = instance.bounds_world;
  if (instance.always_kept) return LaneClass::kAlwaysKept;
  // An inverted box holds nothing; any other box that is not finite bounds nothing.
  if (b.min.x > b.max.x || b.min.y > b.max.y || b.min.z > b.max.z) return LaneClass::kNone;
  return b.finite() ? LaneClass::kLane : LaneClass::kAlwaysKept;
}

WideNode emptyNode() noexcept {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  WideNode node{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t l = 0; l < kWideLanes; ++l) {
      node.offsets[kMinX + axis][l] = kInf;
      node.offsets[kMaxX + axis][l] = -kInf;
    }
  }
  return node;
}

Box boundsOf(const WideNode& node) noexcept {
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    float low = std::numeric_limits<float>::infinity();
    float high = -low;
    for (std::size_t l = 0; l < kWideLanes; ++l) {  // lanes that are not live are inverted
      low = std::min(low, node.offsets[kMinX + a][l]);
      high = std::max(high, node.offsets[kMaxX + a][l]);
    }
    if (node.live == 0) continue;
    box.min[axis] = addDown(node.origin[a], static_cast<double>(low));
    box.max[axis] = addUp(node.origin[a], static_cast<double>(high));
  }
  return box;
}

void setListed(std::vector<ObjectId>& list, ObjectId id, bool wanted) {
  const auto at = std::lower_bound(list.begin(), list.end(), id);
  const bool there = at != list.end() && *at == id;
  if (wanted && !there) list.insert(at, id);
  if (!wanted && there) list.erase(at);
}

Box boundsOfLane(const WideNode& node, std::size_t lane) noexcept {
  WideNode alone = emptyNode();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    alone.origin[axis] = node.origin[axis];
    alone.offsets[kMinX + axis][0] = node.offsets[kMinX + axis][lane];
    alone.offsets[kMaxX + axis][0] = node.offsets[kMaxX + axis][lane];
  }
  alone.live = static_cast<std::uint16_t>(node.live >> lane & 1U);
  return boundsOf(alone);
}

void fitNode(WideNode& node, const Box (&boxes)[kWideLanes]) noexcept {
  Box all;
  for (const Box& box : boxes) all.grow(box);
  constexpr float kInf = std::numeric_limits<float>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    // The middle keeps offsets small. It is finite also where the box reaches to infinity.
    const double limit = std::numeric_limits<double>::max();
    const double low = std::max(all.min[axis], -limit), high = std::min(all.max[axis], limit);
    node.origin[a] = all.empty() ? 0.0 : 0.5 * low + 0.5 * high;
    for (std::size_t l = 0; l < kWideLanes; ++l) {
      const Box& box = boxes[l];
      const bool live = !box.empty();
      node.offsets[kMinX + a][l] = live ? offsetDown(box.min[axis], node.origin[a]) : kInf;
      node.offsets[kMaxX + a][l] = live ? offsetUp(box.max[axis], node.origin[a]) : -kInf;
    }
  }
  std::uint32_t live = 0;
  for (std::size_t l = 0; l < kWideLanes; ++l) live |= (boxes[l].empty() ? 0U : 1U) << l;
  node.live = static_cast<std::uint16_t>(live);
}

Result<void> WideBvh::fits(const SceneSnapshot& scene) {
  constexpr std::size_t kMaxObjects = 0x7FFFFFFFU;
  if (scene.objectCount() <= kMaxObjects) return Done{};
  return Error{ErrorCode::kLimit, "scene has " + std::to_string(scene.objectCount()) +
                                      " objects: more than " + std::to_string(kMaxObjects)};
}

void WideBvh::appendObjects(std::uint32_t index, std::vector<ObjectId>& out) const {
  std::vector<std::uint32_t> stack{index};
  while (!stack.empty()) {
    const WideNode& node = nodes_[stack.back()];
    stack.pop_back();
    for (std::size_t l = 0; l < kWideLanes; ++l) {
      if ((node.live >> l & 1U) == 0) continue;
      if (node.child[l].isObject()) {
        out.push_back(node.child[l].objectId());
      } else {
        stack.push_back(node.child[l].nodeIndex());
      }
    }
  }
}

bool WideBvh::degraded() const noexcept {
  // Built trees use lanes / 7 nodes and are at most 11 deep (8^11 > 2^32).
  constexpr std::size_t kTooDeep = 48;
  const std::size_t used = nodes_.size() - free_nodes_.size();
  return deepest_insert_ > kTooDeep || used > 2 * (lanes_taken_ / 7) + 64;
}

std::size_t WideBvh::chunksNotSharedWith(const WideBvh& other) const noexcept {
  std::size_t count = 0;
  for (std::size_t c = 0; c < nodes_.chunkCount(); ++c) {
    if (!nodes_.sharesChunk(c, other.nodes_)) ++count;
  }
  return count;
}

std::size_t WideBvh::bytes() const noexcept {
  return nodes_.bytes() + parent_of_.bytes() + lane_of_.bytes() +
         always_kept_.capacity() * sizeof(ObjectId) +
         free_nodes_.capacity() * sizeof(std::uint32_t);
}

}  // namespace culld
