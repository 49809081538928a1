#include "culling/methods/polygon_tiling_scene.h"

#include <bit>
#include <limits>
#include <utility>
#include <vector>

#include "culling/spatial/wide_bvh_fit.h"

namespace culld {

/// The parts of the objects bound to a node, by the node's boxes.
std::shared_ptr<const BspTree> PolygonTilingScene::treeOf(std::uint32_t node) const {
  std::vector<BspPart> parts;
  for (std::uint32_t at = octree_.node(node).objects; at != OctreeNode::kNone;
       at = octree_.nextLanes(at)) {
    const WideNode& lanes = octree_.lanes(at);
    for (std::uint32_t live = lanes.live; live != 0; live &= live - 1) {
      const auto l = static_cast<std::size_t>(std::countr_zero(live));
      parts.push_back(
          {lanes.child[l].objectId(), boundsOfLane(lanes, l), (lanes.blocking >> l & 1U) != 0});
    }
  }
  return std::make_shared<const BspTree>(BspTree::of(parts, bsp_));
}

PolygonTilingScene PolygonTilingScene::of(SnapshotPtr scene, const PolygonTilingParts& parts) {
  PolygonTilingScene out;
  out.bsp_ = parts.bsp;
  OctreeRules rules;
  rules.leaf_objects = parts.leaf_objects;
  rules.small_share = std::numeric_limits<double>::max();  // strict order: cut wherever planes do
  out.octree_ = Octree::of(*scene, rules);
  out.scene_ = std::move(scene);
  for (std::uint32_t i = 0; i < out.octree_.nodeCount(); ++i) {
    out.trees_.push_back(out.treeOf(i));
    out.tree_bytes_ += out.trees_[i]->bytes();
  }
  return out;
}

PolygonTilingScene PolygonTilingScene::edited(SnapshotPtr next,
                                              std::span<const ObjectId> changed) const {
  std::vector<std::uint32_t> touched;
  PolygonTilingScene out = *this;
  out.octree_ = octree_.edited(*scene_, *next, changed, &touched);
  out.scene_ = std::move(next);
  while (out.trees_.size() < out.octree_.nodeCount()) {
    out.trees_.push_back(std::make_shared<const BspTree>());
  }
  for (const std::uint32_t node : touched) out.trees_.mutableAt(node) = out.treeOf(node);
  return out;
}

}  // namespace culld
