// The parts of a mesh whose blocking triangles close around a volume: each edge is shared by two of
// them. Only such a part has an inside that can occlude.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "culling/core/box.h"
#include "culling/scene/mesh.h"

namespace culld {

struct ClosedPart {
  std::vector<std::uint32_t> triangles;  ///< of the mesh
  bool two_sided = true;                 ///< all of them block from both sides
  Box box_mesh;
};

/// Parts of at most so many triangles, the largest `most_parts`, largest first. COST: O(triangles).
std::vector<ClosedPart> closedParts(const Mesh& mesh, std::size_t most_triangles,
                                    std::size_t most_parts);

Box boxOfTriangles(const Mesh& mesh, std::span<const std::uint32_t> triangles);

}  // namespace culld
