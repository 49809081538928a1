// What of each mesh `gpu-depth-pyramid` draws: convex pieces where the mesh is made of them, else
// its largest flat faces, as outlines are all that a fragment can prove by itself.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/occluders/convex_pieces.h"
#include "culling/occluders/occluder_set.h"

namespace culld {

class GpuOccluders {
 public:
  /// At most `faces` flat faces of a mesh without pieces. COST: O(triangles).
  static GpuOccluders of(const SceneSnapshot& scene, std::size_t faces);

  std::size_t pieceCount(MeshId mesh) const noexcept {
    const OccluderMesh& found = pieces_.mesh(mesh);
    return found.piece_count != 0 ? found.piece_count : faces_[mesh].size();
  }
  /// REQUIRES: i < pieceCount(mesh). Its spans live as long as this.
  ConvexPiece piece(MeshId mesh, std::size_t i) const noexcept {
    const OccluderMesh& found = pieces_.mesh(mesh);
    if (found.piece_count == 0) return faces_[mesh][i];
    return pieces_.piece(found.first_piece + static_cast<std::uint32_t>(i));
  }
  const glm::vec3& largest(MeshId mesh) const noexcept { return pieces_.mesh(mesh).largest; }
  std::size_t bytes() const noexcept;

 private:
  OccluderSet pieces_;
  std::vector<ConvexPieces> faces_;  ///< by mesh; empty where there are pieces
};

}  // namespace culld
