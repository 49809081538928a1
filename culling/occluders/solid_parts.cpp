#include "culling/occluders/solid_parts.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <utility>

#include "culling/raster/object_rows.h"

namespace culld {
namespace {

constexpr double kMostCoordinate = 1e15;  ///< metres; beyond it nothing is proven

/// Of a coordinate: four terms, at most 4 units of their sum (docs/error-model/solids.md §2).
double roundingOf(const std::array<double, 12>& m, const Box& box_mesh) {
  const glm::dvec3 p = glm::max(glm::abs(box_mesh.min), glm::abs(box_mesh.max));
  double most = 0.0;
  for (std::size_t r = 0; r < 12; r += 4) {
    most = std::max(most, std::abs(m[r]) * p.x + std::abs(m[r + 1]) * p.y +
                              std::abs(m[r + 2]) * p.z + std::abs(m[r + 3]));
  }
  return 0x1p-50 * most + 1e-300;
}

bool withinReach(const Box& box) {
  const auto reaches = [](double x) { return std::abs(x) < kMostCoordinate; };
  return reaches(box.min.x) && reaches(box.min.y) && reaches(box.min.z) && reaches(box.max.x) &&
         reaches(box.max.y) && reaches(box.max.z);
}

}  // namespace

SolidParts SolidParts::of(const SceneSnapshot& scene) {
  SolidParts parts(scene);
  parts.of_mesh_.resize(scene.meshCount());
  for (ObjectId id = 0; id < scene.objectCount(); ++id) {
    parts.addObject(id);
    if (parts.parts_.size() > 4 * kMostParts) parts.keepLargest();  // bounds the memory
  }
  parts.keepLargest();
  return parts;
}

void SolidParts::keepLargest() {
  std::stable_sort(parts_.begin(), parts_.end(), [](const SolidPart& a, const SolidPart& b) {
    return halfArea(a.box_world) > halfArea(b.box_world);
  });
  if (parts_.size() > kMostParts) parts_.resize(kMostParts);
}

void SolidParts::addObject(ObjectId id) {
  const Instance& instance = scene_->instance(id);
  if (!instance.active() || instance.always_kept || !withinReach(instance.bounds_world)) return;
  const Mesh& mesh = scene_->mesh(instance.mesh);
  if (mesh.blocking_triangles == 0) return;
  const double turn = handedness(instance.world_from_mesh);
  if (turn == 0.0) return;
  auto& known = of_mesh_[instance.mesh];
  if (known == nullptr) {
    known = std::make_unique<const std::vector<ClosedPart>>(
        closedParts(mesh, kMostTrianglesOfPart, kMostPartsOfMesh));
  }
  for (const ClosedPart& part : *known) {
    const Box box = boundsOf(instance.world_from_mesh, part.box_mesh);
    const double rounding = roundingOf(instance.world_from_mesh, part.box_mesh);
    if (!box.empty()) parts_.push_back({id, &part, box, turn < 0.0, rounding});
  }
}

void SolidParts::appendTriangles(const SolidPart& part, std::vector<WorldTriangle>& out) const {
  const Instance& instance = scene_->instance(part.object);
  const Mesh& mesh = scene_->mesh(instance.mesh);
  for (const std::uint32_t t : part.part->triangles) {
    const auto& corner = mesh.triangles[t];
    WorldTriangle triangle;
    for (std::size_t c = 0; c < 3; ++c) {
      triangle[c] = toWorld(instance.world_from_mesh, glm::dvec3(mesh.positions[corner[c]]));
    }
    out.push_back(triangle);
  }
}

}  // namespace culld
