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
  Box bounds_world;  ///< contains every vertex, rounding included; empty if always_kept
  MeshId mesh = 0;
  std::uint32_t node = 0;             ///< glTF node index: the id in answers files
  std::uint32_t instance_number = 0;  ///< within the node; 0 for plain nodes
  bool hidden = false;                ///< by an edit: neither seen nor blocks
  bool removed = false;               ///< by an edit: for good; the id is not used again
  bool always_kept = false;           ///< unbounded mesh or non-finite transform: in every answer
  /// Can it be in an answer at all? An object without any geometry cannot.
  bool active() const noexcept {
    return !hidden && !removed && (always_kept || !bounds_world.empty());
  }
};

static_assert(sizeof(Instance) <= 160, "docs promise the bytes per instance");

/// A point of mesh space after the map, in double.
inline glm::dvec3 toWorld(const std::array<double, 12>& m, const glm::dvec3& p) noexcept {
  return {m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
          m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]};
}

/// Bounds of a box after the map: every point of it, transformed in double in any order of
/// evaluation, lies inside; so does the exact result. Empty for an empty box.
Box boundsOf(const std::array<double, 12>& world_from_mesh, const Box& bounds_mesh);

/// Puts the object there: bounds and always_kept follow.
void place(Instance& instance, const Mesh& mesh, const std::array<double, 12>& world_from_mesh);

class SceneSnapshot {
 public:
  std::size_t objectCount() const noexcept { return instances_.size(); }  ///< removed ones too
  const Instance& instance(ObjectId id) const noexcept { return instances_[id]; }
  const Mesh& mesh(MeshId id) const noexcept { return fixed_->meshes[id]; }
  std::size_t meshCount() const noexcept { return fixed_->meshes.size(); }
  std::uint64_t version() const noexcept { return version_; }  ///< 1 after loading, +1 per edit
  /// Hash of the content (meshes, instances), not of the history. Equal scenes, equal hashes.
  std::uint64_t contentHash() const noexcept { return content_hash_; }
  /// Triangles of all objects that are not removed, instances counted each.
  std::uint64_t triangleCount() const noexcept { return triangle_count_; }
  /// What a loader found odd and survived, one line each ("mesh 3: 2 non-finite vertices").
  std::span<const std::string> warnings() const noexcept { return fixed_->warnings; }

  /// Memory of meshes and instances, also what other versions share. COST: O(meshes).
  std::size_t bytes() const noexcept;
  /// Instances lie in chunks that versions share; how many of this one's are not in `other`?
  std::size_t chunksNotIn(const SceneSnapshot& other) const noexcept;

 private:
  friend class SceneBuilder;
  friend class SceneEditor;
  /// What no edit changes: one copy for all versions.
  struct FixedParts {
    std::vector<Mesh> meshes;
    std::vector<std::string> warnings;
    std::uint64_t meshes_hash = 0;
  };
  std::uint64_t combinedHash() const;

  ChunkedArray<Instance> instances_;
  std::vector<std::uint64_t> chunk_hashes_;  // one per chunk of instances_
  std::shared_ptr<const FixedParts> fixed_ = std::make_shared<const FixedParts>();
  std::uint64_t version_ = 1;
  std::uint64_t content_hash_ = 0;
  std::uint64_t triangle_count_ = 0;
};

using SnapshotPtr = std::shared_ptr<const SceneSnapshot>;

}  // namespace culld
