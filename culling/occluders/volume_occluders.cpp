#include "culling/occluders/volume_occluders.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <numeric>

#include "culling/core/parallel.h"
#include "culling/occluders/convex_pieces.h"
#include "culling/occluders/solid_hulls.h"

namespace culld {
namespace {

Box boxOf(const ConvexPiece& piece) {
  Box box;
  for (const glm::vec3& p : piece.vertices) box.grow(glm::dvec3(p));
  return box;
}

double sizeOf(const Box& box) { return glm::length(box.max - box.min); }

/// What one mesh offers, before it is packed.
struct Offer {
  ConvexPieces pieces;
  std::vector<SolidHull> hulls;
  std::vector<VolumeOccluder> occluders;  ///< into these
};

void find(const Mesh& mesh, bool hulls, Offer& offer) {
  offer.pieces = ConvexPieces::of(mesh);
  if (hulls && offer.pieces.size() == 0) offer.hulls = solidHulls(mesh);
  for (const SolidHull& hull : offer.hulls)
    offer.occluders.push_back({hull.shape(), hull.box_mesh, true});
  for (std::size_t i = 0; i < offer.pieces.size(); ++i) {
    const ConvexPiece piece = offer.pieces[i];
    offer.occluders.push_back({piece, boxOf(piece), false});
  }
  std::stable_sort(offer.occluders.begin(), offer.occluders.end(),
                   [](const VolumeOccluder& a, const VolumeOccluder& b) {
                     return sizeOf(a.box_mesh) > sizeOf(b.box_mesh);
                   });
  if (offer.occluders.size() > VolumeOccluders::kMostOfMesh)
    offer.occluders.resize(VolumeOccluders::kMostOfMesh);
}

/// By mesh: is it one to look for hulls in? Those of the largest objects are, until `triangles` of
/// them are used up.
std::vector<std::uint8_t> hullMeshes(const SceneSnapshot& scene, std::size_t triangles) {
  std::vector<double> size(scene.meshCount(), 0.0);
  for (std::size_t i = 0; i < scene.objectCount(); ++i) {
    const Instance& instance = scene.instance(static_cast<ObjectId>(i));
    if (instance.active() && !instance.always_kept)
      size[instance.mesh] = std::max(size[instance.mesh], sizeOf(instance.bounds_world));
  }
  std::vector<MeshId> order(size.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](MeshId a, MeshId b) { return size[a] > size[b]; });
  std::vector<std::uint8_t> chosen(size.size(), 0);
  for (const MeshId mesh : order) {
    const std::size_t count = scene.mesh(mesh).triangles.size();
    if (count > triangles) continue;
    triangles -= count;
    chosen[mesh] = 1;
  }
  return chosen;
}

}  // namespace

VolumeOccluders VolumeOccluders::of(const SceneSnapshot& scene, std::size_t hull_triangles) {
  std::vector<Offer> offers(scene.meshCount());
  const std::vector<std::uint8_t> with_hulls = hullMeshes(scene, hull_triangles);
  parallelFor(offers.size(), [&](std::size_t i) {
    const Mesh& mesh = scene.mesh(static_cast<MeshId>(i));
    if (!mesh.unbounded) find(mesh, with_hulls[i] != 0, offers[i]);
  });
  VolumeOccluders all;
  all.ends_.push_back(0);
  for (Offer& offer : offers) {
    for (const VolumeOccluder& occluder : offer.occluders) all.add(occluder);
    all.ends_.push_back(static_cast<std::uint32_t>(all.shapes_.size()));
    offer = {};
  }
  return all;
}

void VolumeOccluders::add(const VolumeOccluder& occluder) {
  const ConvexPiece& shape = occluder.shape;
  vertices_.insert(vertices_.end(), shape.vertices.begin(), shape.vertices.end());
  faces_.insert(faces_.end(), shape.faces.begin(), shape.faces.end());
  edges_.insert(edges_.end(), shape.edges.begin(), shape.edges.end());
  shapes_.push_back({static_cast<std::uint32_t>(vertices_.size()),
                     static_cast<std::uint32_t>(faces_.size()),
                     static_cast<std::uint32_t>(edges_.size()), occluder.box_mesh, occluder.solid});
}

VolumeOccluder VolumeOccluders::occluder(MeshId mesh, std::uint32_t i) const noexcept {
  const std::uint32_t at = ends_[mesh] + i;
  const Shape begin = at == 0 ? Shape{0, 0, 0, {}, false} : shapes_[at - 1];
  const Shape& end = shapes_[at];
  return {{std::span(vertices_).subspan(begin.vertex, end.vertex - begin.vertex),
           std::span(faces_).subspan(begin.face, end.face - begin.face),
           std::span(edges_).subspan(begin.edge, end.edge - begin.edge)},
          end.box_mesh,
          end.solid};
}

std::size_t VolumeOccluders::bytes() const noexcept {
  return ends_.capacity() * sizeof(std::uint32_t) + shapes_.capacity() * sizeof(Shape) +
         vertices_.capacity() * sizeof(glm::vec3) + faces_.capacity() * sizeof(PieceFace) +
         edges_.capacity() * sizeof(PieceEdge);
}

}  // namespace culld
