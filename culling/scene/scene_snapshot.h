// One version of a scene: immutable, content-hashed, shared by every thread that culls it.
// Edits make a new snapshot (edit.h) that shares all chunks which did not change.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "culling/core/box.h"
#include "culling/core/ids.h"
#include "culling/scene/chunked_array.h"
#include "culling/scene/mesh.h"

namespace culld {

/// One object: a glTF node with a mesh, or one instance of an instanced node.
struct Instance {
  /// Rows of the affine map mesh space -> world space: world[i] = dot(row_i.xyz, p) + row_i.w.
  std::array<double, 12> world_from_mesh{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  Box bounds_world;              ///< contains every vertex, rounding included; see `always_kept`
  MeshId mesh = 0;
  std::uint32_t node = 0;        ///< glTF node index: the id in answers files
  std::uint32_t instance_number = 0;  ///< within the node; 0 for plain nodes
  bool hidden = false;           ///< by an edit: neither seen nor blocks
  bool removed = false;          ///< by an edit: for good; the id is not used again
  bool mirrored = false;         ///< negative determinant: the front of a triangle is its CW side
  bool always_kept = false;      ///< unbounded mesh or non-finite transform: in every answer
  bool active() const noexcept { return !hidden && !removed; }
};

class SceneSnapshot {
 public:
  std::size_t objectCount() const noexcept { return instances_.size(); }  ///< removed ones too
  const Instance& instance(ObjectId id) const noexcept { return instances_[id]; }
  const Mesh& mesh(MeshId id) const noexcept { return *meshes_[id]; }
  std::size_t meshCount() const noexcept { return meshes_.size(); }
  std::uint64_t version() const noexcept { return version_; }  ///< 1 after loading, +1 per edit
  /// Hash of the content (meshes, instances), not of the history. Equal scenes, equal hashes.
  std::uint64_t contentHash() const noexcept { return content_hash_; }
  /// Triangles of all objects that are not removed, instances counted each.
  std::uint64_t triangleCount() const noexcept { return triangle_count_; }
  /// What a loader found odd and survived, one line each ("mesh 3: 2 non-finite vertices").
  std::span<const std::string> warnings() const noexcept { return warnings_; }

 private:
  friend class SceneBuilder;
  friend class SceneEditor;
  ChunkedArray<Instance> instances_;
  std::vector<std::shared_ptr<const Mesh>> meshes_;
  std::vector<std::string> warnings_;
  std::uint64_t version_ = 1;
  std::uint64_t content_hash_ = 0;
  std::uint64_t triangle_count_ = 0;
};

using SnapshotPtr = std::shared_ptr<const SceneSnapshot>;

}  // namespace culld
