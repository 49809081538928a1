// An 8-wide bounding volume hierarchy over the objects of a snapshot: one node is one call of an
// 8-lane kernel. Few objects get the nodes and no hierarchy: a flat list, all of it roots. Lanes
// are always eight, whatever the SIMD width, so trees, answers and hashes do not depend on the
// machine. Nodes are packed full at build time (after Garcia, Lopez, Leutenegger 1998, "A greedy
// algorithm for bulk loading R-trees") with splits chosen by binned surface area, and live in
// shared chunks: an edited tree shares every chunk that the edit did not touch.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "culling/core/box.h"
#include "culling/core/ids.h"
#include "culling/core/result.h"
#include "culling/scene/chunked_array.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

/// What a lane of a WideNode refers to: nothing, an object, or another node.
class ChildRef {
 public:
  constexpr ChildRef() = default;
  static constexpr ChildRef object(ObjectId id) { return ChildRef(id | kObjectBit); }
  static constexpr ChildRef node(std::uint32_t index) { return ChildRef(index); }
  constexpr bool empty() const { return bits_ == kNothing; }
  constexpr bool isObject() const { return (bits_ & kObjectBit) != 0 && !empty(); }
  constexpr bool isNode() const { return (bits_ & kObjectBit) == 0; }
  constexpr ObjectId objectId() const { return bits_ & ~kObjectBit; }  ///< REQUIRES: isObject()
  constexpr std::uint32_t nodeIndex() const { return bits_; }          ///< REQUIRES: isNode()
  bool operator==(const ChildRef&) const = default;

 private:
  static constexpr std::uint32_t kObjectBit = 0x80000000U;
  static constexpr std::uint32_t kNothing = 0xFFFFFFFFU;
  explicit constexpr ChildRef(std::uint32_t bits) : bits_(bits) {}
  std::uint32_t bits_ = kNothing;
};

inline constexpr std::size_t kWideLanes = 8;

/// Rows of WideNode::offsets.
enum BoxRow : std::size_t { kMinX, kMinY, kMinZ, kMaxX, kMaxY, kMaxZ, kBoxRows };

/// Lane l bounds child[l] by the box [origin + offsets[kMin*][l], origin + offsets[kMax*][l]].
/// GUARANTEES: evaluated exactly, that box contains the object's bounds_world, or every lane box of
/// the child node. Lanes outside `live` hold an inverted box (+inf, -inf) and answer nothing.
struct alignas(32) WideNode {
  float offsets[kBoxRows][kWideLanes];
  double origin[3];
  ChildRef child[kWideLanes];  ///< also set for hidden objects, whose lane is not live
  std::uint16_t live;          ///< bit l: something below lane l may be answered
  std::uint16_t blocking;      ///< bit l: and something there has triangles that block
  std::uint32_t live_objects;  ///< at and below this node
};
static_assert(sizeof(WideNode) == 256);

/// The node's origin as seen from the eye.
inline std::array<double, 3> originFrom(const WideNode& node,
                                        const glm::dvec3& eye_world) noexcept {
  return {node.origin[0] - eye_world.x, node.origin[1] - eye_world.y, node.origin[2] - eye_world.z};
}

class WideBvh {
 public:
  static constexpr std::uint32_t kRoot = 0;
  static constexpr std::uint32_t kNoLane = 0xFFFFFFFFU;

  /// ERROR: kLimit: more objects than a ChildRef can name (2^31 - 1).
  static Result<void> fits(const SceneSnapshot& scene);

  /// Scenes of at most this many objects are kept as a flat list (docs/methods/frustum.md).
  static constexpr std::size_t kFewObjects = 128;

  /// A flat list for few objects, else a hierarchy. REQUIRES: fits(scene). COST: as build.
  static WideBvh of(const SceneSnapshot& scene);

  /// Active objects in groups of near ones, all of them roots. REQUIRES: fits(scene).
  static WideBvh flat(const SceneSnapshot& scene);

  /// A hierarchy, however few objects there are. REQUIRES: fits(scene). Deterministic for any
  /// number of threads (0: as many as cores). COST: O(n log n); 200 000 objects take well under 150
  /// ms on two cores (docs/methods/frustum.md).
  static WideBvh build(const SceneSnapshot& scene, std::size_t threads = 0);

  /// The tree of the next version of the scene. Shares all chunks that the edits did not touch.
  /// REQUIRES: fits(next); `next` came from this tree's snapshot by edits of the objects in
  /// `changed`. COST: O(changed * depth) plus one pointer per chunk.
  WideBvh edited(const SceneSnapshot& next, std::span<const ObjectId> changed) const;

  /// True if there is no node, not even a root: no object has a lane.
  bool empty() const noexcept { return nodes_.size() == 0; }
  /// Walks begin at nodes [0, rootCount()): one in a hierarchy, all of them in a flat list.
  std::size_t rootCount() const noexcept { return flat_ ? nodes_.size() : empty() ? 0 : 1; }
  const WideNode& node(std::uint32_t index) const noexcept { return nodes_[index]; }
  std::size_t nodeCount() const noexcept { return nodes_.size(); }  ///< unused ones too
  /// 8 * node + lane of the node's parent, or kNoLane at a root.
  std::uint32_t parentOf(std::uint32_t index) const noexcept { return parent_of_[index]; }
  /// 8 * node + lane where the object lives, or kNoLane. REQUIRES: a hierarchy.
  std::uint32_t laneOf(ObjectId id) const noexcept { return lane_of_[id]; }
  std::size_t liveObjects() const noexcept {
    return flat_ ? lanes_taken_ : empty() ? 0 : nodes_[kRoot].live_objects;
  }
  /// Active objects without a bound: part of every answer. Ascending.
  std::span<const ObjectId> alwaysKept() const noexcept { return always_kept_; }

  /// Appends every live object at and below `index`, in no particular order.
  void appendObjects(std::uint32_t index, std::vector<ObjectId>& out) const;

  /// Edits make the tree looser and deeper, never wrong. True once a rebuild would pay.
  bool degraded() const noexcept;
  std::size_t editsSinceBuild() const noexcept { return edits_since_build_; }
  std::size_t bytes() const noexcept;
  /// Chunks of nodes that this tree holds alone: what an edit of `other` has copied.
  std::size_t chunksNotSharedWith(const WideBvh& other) const noexcept;

 private:
  friend class WideBvhBuilder;
  friend class WideBvhEditor;
  using Nodes = ChunkedArray<WideNode, 64>;

  Nodes nodes_;
  ChunkedArray<std::uint32_t> parent_of_;  ///< only edits ask
  ChunkedArray<std::uint32_t> lane_of_;
  std::vector<ObjectId> always_kept_;
  std::vector<std::uint32_t> free_nodes_;
  bool flat_ = false;
  std::size_t lanes_taken_ = 0;  ///< objects with a lane; in a hierarchy hidden ones too
  std::size_t edits_since_build_ = 0;
  std::size_t deepest_insert_ = 0;
};

}  // namespace culld
