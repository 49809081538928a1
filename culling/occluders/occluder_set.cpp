#include "culling/occluders/occluder_set.h"

#include <cstring>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <map>
#include <string>

#include "culling/core/parallel.h"
#include "culling/occluders/convex_pieces.h"

namespace culld {
namespace {

/// Area of the mesh's blocking triangles as a share of the surface of its box.
double fillOf(const Mesh& mesh) {
  double area = 0.0;
  for (const Surface& surface : mesh.surfaces) {
    if (!surface.blocks) continue;
    for (std::uint32_t t = 0; t < surface.triangle_count; ++t) {
      const auto& corner = mesh.triangles[surface.first_triangle + t];
      const glm::dvec3 p(mesh.positions[corner[0]]);
      area += 0.5 * glm::length(glm::cross(glm::dvec3(mesh.positions[corner[1]]) - p,
                                           glm::dvec3(mesh.positions[corner[2]]) - p));
    }
  }
  const glm::dvec3 s = mesh.bounds.max - mesh.bounds.min;
  const double surface = 2.0 * (s.x * s.y + s.y * s.z + s.z * s.x);
  return surface > 0.0 ? area / surface : 0.0;
}

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
  std::vector<double> fills(scene.meshCount());
  parallelFor(found.size(), [&](std::size_t i) {
    const Mesh& mesh = scene.mesh(static_cast<MeshId>(i));
    found[i] = ConvexPieces::of(mesh);
    fills[i] = fillOf(mesh);
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
    out.fill = fills[i];
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
