// A part of a mesh whose outline is convex from wherever one sees it: a box, a prism, a panel.
// culling/occluders finds them, culling/raster draws each as one polygon.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>

namespace culld {

/// Parts of more vertices or faces are not worth one polygon.
inline constexpr std::size_t kMostPieceVertices = 32, kMostPieceFaces = 60;

/// Marks the missing face beside an open edge.
inline constexpr std::uint8_t kNoFace = 0xFF;

/// Triangles in exactly one plane of mesh space, all turned the same way. These three vertices, CCW
/// from the front, are one of them.
struct PieceFace {
  std::array<std::uint8_t, 3> corner;
};

/// Of two different faces, or at the rim of one. Runs CCW around `left` and the other way around
/// `right`. Its ends are vertices of the mesh.
struct PieceEdge {
  std::uint8_t from, to, left, right;
};

/// Indices are within the piece. That it is convex is a promise of use only: an outline that is not
/// covers less, never too much (docs/error-model.md §3.1).
struct ConvexPiece {
  std::span<const glm::vec3> vertices;  ///< mesh space
  std::span<const PieceFace> faces;
  std::span<const PieceEdge> edges;
};

}  // namespace culld
