// The octree of BSP trees of method `polygon-tiling`: each node's own objects in a BSP tree.
#pragma once
#include <cstdint>
#include <memory>
#include <span>

#include "culling/scene/chunked_array.h"
#include "culling/scene/scene_snapshot.h"
#include "culling/spatial/bsp_tree.h"
#include "culling/spatial/octree.h"

namespace culld {

struct PolygonTilingParts {
  std::uint32_t leaf_objects = 64;
  std::uint32_t levels = 15;
  bool bsp = true;
};

class PolygonTilingScene {
 public:
  /// REQUIRES: WideBvh::fits(scene).
  static PolygonTilingScene of(SnapshotPtr scene, const PolygonTilingParts& parts);
  PolygonTilingScene edited(SnapshotPtr next, std::span<const ObjectId> changed) const;

  const SceneSnapshot& snapshot() const noexcept { return *scene_; }
  const Octree& octree() const noexcept { return octree_; }
  const BspTree& tree(std::uint32_t node) const noexcept { return *trees_[node]; }
  std::size_t bytes() const noexcept { return octree_.bytes() + trees_.bytes() + tree_bytes_; }

 private:
  std::shared_ptr<const BspTree> treeOf(std::uint32_t node) const;

  SnapshotPtr scene_;
  Octree octree_;
  ChunkedArray<std::shared_ptr<const BspTree>, 64> trees_;  ///< by node of the octree
  std::size_t tree_bytes_ = 0;                              ///< as built
  bool bsp_ = true;
};

}  // namespace culld
