// The meshes of a scene as `item-buffer` draws them: each one's triangles sorted by what they do.
// No edit changes meshes, so all versions of a scene share this, and its upload.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "culling/gpu/item_pass.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

/// What a run of triangles does, a place in ItemMesh::runs.
enum ItemRun : std::uint8_t { kBlockFront, kBlockBoth, kShowFront, kShowBoth, kItemRuns };

struct ItemMesh {
  struct Run {
    std::uint32_t first_index = 0, index_count = 0;
  };
  std::array<Run, kItemRuns> runs;
  glm::dvec3 largest{0.0};  ///< of |x|, |y|, |z| over its vertices
  /// Points and lines, which have no area: their objects are answered wherever they are.
  bool thin = false;

  bool blocks() const noexcept {
    return runs[kBlockFront].index_count + runs[kBlockBoth].index_count != 0;
  }
  bool shows() const noexcept {
    return runs[kShowFront].index_count + runs[kShowBoth].index_count != 0;
  }
};

class ItemMeshes {
 public:
  /// COST: O(meshes + surfaces).
  explicit ItemMeshes(const SceneSnapshot& scene);

  const ItemMesh& mesh(MeshId id) const noexcept { return meshes_[id]; }
  /// Good while this and `scene`, any version of the scene, live.
  gpu::MeshSource source(const SceneSnapshot& scene) const;
  /// On the GPU.
  std::uint64_t uploadedBytes() const noexcept {
    return (3 * vertices_ + indices_) * sizeof(std::uint32_t);
  }
  std::size_t bytes() const noexcept { return meshes_.capacity() * sizeof(ItemMesh); }

 private:
  std::vector<ItemMesh> meshes_;
  std::uint64_t vertices_ = 0, indices_ = 0;
  std::uint64_t key_;
};

}  // namespace culld
