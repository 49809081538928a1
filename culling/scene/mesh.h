// One mesh, shared by all its instances: welded triangles, which of their edges meet, what they
// block.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <vector>

#include "culling/core/box.h"

namespace culld {

/// Marks a half-edge without a partner in Mesh::partners.
inline constexpr std::uint32_t kOpenEdge = 0xFFFFFFFFU;

/// A run of triangles with the same material behaviour.
struct Surface {
  std::uint32_t first_triangle = 0;
  std::uint32_t triangle_count = 0;
  bool blocks = true;         ///< OPAQUE without transmission: hides what is behind it
  bool double_sided = false;  ///< seen (and blocks) from both sides
  bool operator==(const Surface&) const = default;
};

/// Mesh space: the node's local coordinates. Immutable once in a snapshot.
/// Positions are welded: two vertices with equal coordinates (-0 is 0) are one. Triangles with a
/// non-finite or repeated vertex are dropped; they are neither seen nor block
/// (`dropped_triangles`).
struct Mesh {
  std::vector<glm::vec3> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< CCW seen from the front
  /// Half-edge h = 3 * triangle + e runs from corner e to corner (e + 1) % 3. partners[h] is the
  /// half-edge that runs the other way along the same edge of this mesh, or kOpenEdge. Each
  /// half-edge has at most one partner; where more than two meet, some stay open.
  std::vector<std::uint32_t> partners;
  std::vector<Surface> surfaces;         ///< cover [0, triangles.size()) in order
  Box bounds;                            ///< of all kept triangles, of points and lines too
  std::uint32_t blocking_triangles = 0;  ///< of the surfaces that block
  std::uint32_t dropped_triangles = 0;
  std::uint32_t non_finite_vertices = 0;  ///< of those that a triangle uses
  std::uint32_t points_and_lines = 0;     ///< primitives that are seen and never block
  /// Skinned, morphed or with non-finite vertices: no bound holds for it, so its objects are always
  /// kept and never block.
  bool unbounded = false;

  std::size_t bytes() const noexcept;
};

}  // namespace culld
