// Puts meshes and instances together into the first snapshot of a scene.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "culling/core/result.h"
#include "culling/scene/mesh.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

/// Triangles as a file or a generator gives them, before welding.
struct RawSurface {
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> indices;  ///< three per triangle, each < positions.size()
  bool blocks = true;
  bool double_sided = false;
};

/// Welds the surfaces of one mesh, pairs their edges, bounds them. Never fails: what is degenerate
/// or not finite is dropped and counted; vertices that no triangle uses are left out.
/// REQUIRES: fewer than 2^32 - 1 positions and 2^32 / 3 triangles. COST: O(n log n), sort-based.
Mesh makeMesh(const std::vector<RawSurface>& surfaces);

class SceneBuilder {
 public:
  MeshId addMesh(Mesh mesh);
  /// `world_from_mesh`: three rows of four. REQUIRES: mesh was added.
  ObjectId addInstance(MeshId mesh, const std::array<double, 12>& world_from_mesh,
                       std::uint32_t node, std::uint32_t instance_number = 0);
  void warn(std::string line);
  /// Bounds, flags and hashes everything, warns of objects without a finite place. The builder is
  /// empty afterwards.
  SnapshotPtr finish();

 private:
  void warnOfLost();

  std::unique_ptr<SceneSnapshot> scene_ = std::make_unique<SceneSnapshot>();
  SceneSnapshot::FixedParts fixed_;
  std::uint64_t lost_ = 0;  // objects of bounded meshes whose place is not finite
  std::uint32_t first_lost_node_ = 0;
};

}  // namespace culld
