#include "culling/occluders/occluder_set.h"

#include <cstring>
#include <glm/common.hpp>
#include <map>
#include <string>

#include "culling/core/parallel.h"
#include "culling/occluders/convex_pieces.h"

namespace culld {
namespace {

/// Equal for equal faces and edges.
std::string shapeKey(const ConvexPiece& piece) {
  static_assert(sizeof(PieceFace) == 3 && sizeof(PieceEdge) == 4);  // no padding
  std::string key(3 * piece.faces.size() + 4 * piece.edges.size(), '\0');
  if (!piece.faces.empty()) std::memcpy(key.data(), piece.faces.data(), piece.faces.size_bytes());
  if (!piece.edges.empty()) {
    std::memcpy(key.data() + piece.faces.size_bytes(), piece.edges.data(),
                piece.edges.size_bytes());
  }
  return key;
}

}  // namespace

OccluderSet OccluderSet::of(const SceneSnapshot& scene) {
  std::vector<ConvexPieces> found(scene.meshCount());
  parallelFor(found.size(), [&](std::size_t i) {
    found[i] = ConvexPieces::of(scene.mesh(static_cast<MeshId>(i)));
  });
  OccluderSet set;
  std::map<std::string, std::uint32_t> shape_of_key;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const Mesh& mesh = scene.mesh(static_cast<MeshId>(i));
    OccluderMesh out;
    out.first_piece = static_cast<std::uint32_t>(set.pieces_.size());
    out.piece_count = static_cast<std::uint32_t>(found[i].size());
    out.blocking_triangles = mesh.blocking_triangles;
    out.vertices = static_cast<std::uint32_t>(mesh.positions.size());
    out.largest = glm::vec3(glm::max(glm::abs(mesh.bounds.min), glm::abs(mesh.bounds.max)));
    set.meshes_.push_back(out);
    for (std::size_t p = 0; p < found[i].size(); ++p) {
      const ConvexPiece piece = found[i][p];
      const auto [at, fresh] =
          shape_of_key.try_emplace(shapeKey(piece), static_cast<std::uint32_t>(set.shapes_.size()));
      if (fresh) {
        set.shapes_.push_back(
            {{piece.faces.begin(), piece.faces.end()}, {piece.edges.begin(), piece.edges.end()}});
      }
      set.pieces_.push_back({static_cast<std::uint32_t>(set.vertices_.size()),
                             static_cast<std::uint32_t>(piece.vertices.size()), at->second});
      set.vertices_.insert(set.vertices_.end(), piece.vertices.begin(), piece.vertices.end());
    }
    found[i] = {};
  }
  set.pieces_.shrink_to_fit();
  set.vertices_.shrink_to_fit();
  return set;
}

ConvexPiece OccluderSet::piece(std::uint32_t index) const noexcept {
  const Piece& piece = pieces_[index];
  const Shape& shape = shapes_[piece.shape];
  return {std::span(vertices_).subspan(piece.first_vertex, piece.vertex_count), shape.faces,
          shape.edges};
}

std::size_t OccluderSet::bytes() const noexcept {
  std::size_t bytes = meshes_.capacity() * sizeof(OccluderMesh) +
                      pieces_.capacity() * sizeof(Piece) + vertices_.capacity() * sizeof(glm::vec3);
  for (const Shape& shape : shapes_) {
    bytes += sizeof(shape) + shape.faces.capacity() * sizeof(PieceFace) +
             shape.edges.capacity() * sizeof(PieceEdge);
  }
  return bytes;
}

}  // namespace culld
