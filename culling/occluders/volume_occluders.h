// The convex shapes of a scene's meshes that occlusion volumes can be made from, largest first.
// Meshes never change, so edits share it.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/core/ids.h"
#include "culling/occluders/occlusion_volume.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

class VolumeOccluders {
 public:
  /// Of one mesh, the smaller ones are left out.
  static constexpr std::size_t kMostOfMesh = 64;

  /// Hulls are looked for in meshes of so many triangles in all: in the larger objects' meshes
  /// first.
  static constexpr std::size_t kMostHullTriangles = std::size_t{1} << 19;

  /// Meshes that are not convex pieces offer hulls within their closed parts, if those may be
  /// looked for in `hull_triangles`. COST: O(objects + triangles), on all cores; for hulls 2 to 20
  /// us a triangle of a closed part.
  static VolumeOccluders of(const SceneSnapshot& scene,
                            std::size_t hull_triangles = kMostHullTriangles);

  std::uint32_t countOf(MeshId mesh) const noexcept { return ends_[mesh + 1] - ends_[mesh]; }
  /// The `i`-th largest of a mesh. Its spans live as long as this.
  VolumeOccluder occluder(MeshId mesh, std::uint32_t i) const noexcept;
  std::size_t size() const noexcept { return shapes_.size(); }
  std::size_t bytes() const noexcept;

 private:
  struct Shape {
    std::uint32_t vertex, face, edge;  ///< where its parts end
    Box box_mesh;
    bool solid;
  };
  void add(const VolumeOccluder& occluder);

  std::vector<std::uint32_t> ends_;  ///< by mesh: where its shapes begin, and the end of all
  std::vector<Shape> shapes_;
  std::vector<glm::vec3> vertices_;
  std::vector<PieceFace> faces_;
  std::vector<PieceEdge> edges_;
};

}  // namespace culld
