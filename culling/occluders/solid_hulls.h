// Convex hulls that lie within the closed parts of a mesh: a house with gables or an L of walls is
// no convex piece, but a convex body fits into it. "An occluder should not be larger than what it
// stands for" (Bacik 2002) is checked triangle by triangle, however the hull was found
// (docs/error-model/occlusion-volumes.md §5).
#pragma once
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "culling/core/box.h"
#include "culling/core/convex_piece.h"
#include "culling/scene/mesh.h"

namespace culld {

struct SolidHull {
  std::vector<glm::vec3> vertices;
  std::vector<PieceFace> faces;
  std::vector<PieceEdge> edges;
  Box box_mesh;  ///< of the closed part around it
  ConvexPiece shape() const noexcept { return {vertices, faces, edges}; }
};

/// Parts of more triangles are left alone; so are all but the largest parts of a mesh.
inline constexpr std::size_t kMostSolidTriangles = 1024, kMostSolids = 16;

/// GUARANTEES: a segment from outside `box_mesh` to a point of a hull passes through a blocking
/// side of the mesh within `box_mesh`, before it or there. COST: O(triangles), for those of closed
/// parts 2 to 20 us each.
std::vector<SolidHull> solidHulls(const Mesh& mesh);

/// Does the convex hull of `vertices` surely lie inside the closed surface of `part`, triangles of
/// the mesh? With `any_side`, inside of a surface that is turned inwards counts as well.
/// REQUIRES: every edge of `part` is shared by two of its triangles that run along it in opposite
/// directions.
bool surelyInside(std::span<const glm::vec3> vertices, const Mesh& mesh,
                  std::span<const std::uint32_t> part, bool any_side);

}  // namespace culld
