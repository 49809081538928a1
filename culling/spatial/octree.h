// An octree over the objects of a snapshot (Greene, Kass, Miller 1993, section 3): cubes split by
// their three middle planes while they hold more than a few objects. An object that a plane cuts is
// bound to the cube it cuts, unless it is small there: then it goes down into every octant that it
// touches, so that no large cube is kept visible by small things. Departs from it: cubes only say
// where to split; what is tested are the boxes of what lies in them, eight at a time, and chains of
// cubes with a single octant are left out. Nodes live in shared chunks: an edited octree shares
// every chunk that the edit did not touch.
#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "culling/core/box.h"
#include "culling/core/ids.h"
#include "culling/core/result.h"
#include "culling/scene/chunked_array.h"
#include "culling/scene/scene_snapshot.h"
#include "culling/spatial/wide_bvh.h"

namespace culld {

struct OctreeRules {
  std::uint32_t leaf_objects = 32;  ///< a cube with no more is not split
  /// An object is small in a cube if its longest side is less than this share of an octant's edge.
  /// 0: every object that a plane cuts stays there.
  double small_share = 0.5;
};

/// Boxes are stored as lanes of WideNodes, for the kernels that take those.
struct OctreeNode {
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  glm::dvec3 centre{0.0};          ///< where its three planes meet
  double half_m = 0.0;             ///< half the cube's edge
  std::uint32_t children = kNone;  ///< box lanes: lane l is octant l, far on axis i if bit i is set
  std::uint32_t objects = kNone;   ///< first box lanes of the objects bound here
};

class Octree {
 public:
  static constexpr std::uint32_t kRoot = 0;

  /// REQUIRES: WideBvh::fits(scene). COST: O(n depth); at most four lanes per object on average,
  /// and at most 48 levels.
  static Octree of(const SceneSnapshot& scene, const OctreeRules& rules);
  /// The octree of the next version of the scene. Never wrong, and looser with many edits; built
  /// anew once a rebuild pays. REQUIRES: fits; `next` came from `scene`, which this is of, by edits
  /// of the objects in `changed`. COST: O(changed * depth) plus one pointer per chunk.
  /// `touched`: gets the nodes whose own objects changed, ascending; all of them after a rebuild.
  Octree edited(const SceneSnapshot& scene, const SceneSnapshot& next,
                std::span<const ObjectId> changed,
                std::vector<std::uint32_t>* touched = nullptr) const;

  bool empty() const noexcept { return nodes_.size() == 0; }
  std::size_t nodeCount() const noexcept { return nodes_.size(); }
  const OctreeNode& node(std::uint32_t index) const noexcept { return nodes_[index]; }
  /// Eight boxes. An object's box is only what of it lies in the octant: it is hidden if all its
  /// boxes are. GUARANTEES: as WideNode's.
  const WideNode& lanes(std::uint32_t index) const noexcept { return lanes_[index]; }
  /// The next lanes of the same node's objects, or OctreeNode::kNone.
  std::uint32_t nextLanes(std::uint32_t index) const noexcept { return next_[index]; }
  /// Contains everything in the octree.
  const Box& bounds() const noexcept { return bounds_; }
  /// Active objects without a bound: part of every answer. Ascending.
  std::span<const ObjectId> alwaysKept() const noexcept { return always_kept_; }
  std::size_t laneCount() const noexcept { return lanes_taken_; }  ///< of objects, all together

  /// Appends every object at and below `index`, some more than once.
  void appendObjects(std::uint32_t index, std::vector<ObjectId>& out) const;
  std::size_t bytes() const noexcept;
  /// Chunks of nodes and boxes that this octree holds alone.
  std::size_t chunksNotSharedWith(const Octree& other) const noexcept;

 private:
  friend class OctreeBuilder;
  friend class OctreeEditor;

  OctreeRules rules_;
  ChunkedArray<OctreeNode, 64> nodes_;
  ChunkedArray<WideNode, 64> lanes_;
  ChunkedArray<std::uint32_t> next_;  ///< by lanes
  std::vector<ObjectId> always_kept_;
  Box bounds_;
  std::size_t objects_ = 0;  ///< at the last build
  std::size_t lanes_taken_ = 0;
  std::size_t edits_since_build_ = 0;
};

}  // namespace culld
