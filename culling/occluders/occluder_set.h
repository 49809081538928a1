// What a scene's meshes can hide behind them, packed for the walk: a few dozen bytes a mesh, pieces
// of one shape sharing their faces and edges. Meshes never change, so edits share it.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/core/convex_piece.h"
#include "culling/core/ids.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

/// Of one mesh.
struct OccluderMesh {
  std::uint32_t first_piece = 0, piece_count = 0;  ///< no piece: its triangles are drawn as sheets
  std::uint32_t blocking_triangles = 0;
  std::uint32_t vertices = 0;
  glm::vec3 largest{0.0F};  ///< of |x|, |y|, |z| over its vertices
  double fill = 0.0;        ///< area of what blocks, as a share of the surface of the mesh's box
  /// What is drawn one by one: pieces, or triangles where there are none.
  std::uint32_t polygons() const noexcept {
    return piece_count != 0 ? piece_count : blocking_triangles;
  }
};

class OccluderSet {
 public:
  /// COST: O(triangles), on all cores.
  static OccluderSet of(const SceneSnapshot& scene);

  const OccluderMesh& mesh(MeshId id) const noexcept { return meshes_[id]; }
  /// The spans live as long as this.
  ConvexPiece piece(std::uint32_t index) const noexcept;
  std::size_t pieceCount() const noexcept { return pieces_.size(); }
  std::size_t shapeCount() const noexcept { return shapes_.size(); }
  std::size_t bytes() const noexcept;

 private:
  /// How a piece's vertices are joined.
  struct Shape {
    std::vector<PieceFace> faces;
    std::vector<PieceEdge> edges;
  };
  struct Piece {
    std::uint32_t first_vertex, vertex_count, shape;
  };

  std::vector<OccluderMesh> meshes_;
  std::vector<Piece> pieces_;
  std::vector<glm::vec3> vertices_;
  std::vector<Shape> shapes_;
};

}  // namespace culld
