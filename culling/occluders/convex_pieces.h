// Finds the parts of a mesh that are convex: connected triangles, opaque and single-sided, whose
// vertices all lie behind each of their planes. Walls, slabs, beams and houses are little else.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/core/convex_piece.h"
#include "culling/scene/mesh.h"

namespace culld {

class ConvexPieces {
 public:
  /// Empty unless every blocking triangle of the mesh belongs to such a part, of at most
  /// kMostPieceVertices and kMostPieceFaces: the others have to be drawn as sheets anyway. COST:
  /// O(triangles).
  static ConvexPieces of(const Mesh& mesh);
  /// The flat faces of any mesh, each a piece of its own, convex or not: joined triangles in
  /// exactly one plane, as of() would join them. Double-sided ones come twice, once for each side.
  /// Those of more than kMostPieceVertices vertices are left out, and all but the `most` largest.
  /// COST: O(triangles).
  static ConvexPieces facesOf(const Mesh& mesh, std::size_t most);

  std::size_t size() const noexcept { return ends_.size(); }
  ConvexPiece operator[](std::size_t i) const noexcept;
  /// Triangles of the mesh that the pieces stand for.
  std::uint32_t triangles() const noexcept { return triangles_; }
  std::size_t bytes() const noexcept;

 private:
  friend class PieceFinder;
  struct End {
    std::uint32_t vertex, face, edge;
  };

  std::vector<glm::vec3> vertices_;
  std::vector<PieceFace> faces_;
  std::vector<PieceEdge> edges_;
  std::vector<End> ends_;  ///< where each piece's parts end
  std::uint32_t triangles_ = 0;
};

}  // namespace culld
