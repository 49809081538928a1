#include "culling/oracle/ray_scene.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "culling/core/parallel.h"

namespace culld::oracle {
namespace {

constexpr std::uint32_t kNotFlattened = 0xFFFFFFFFU;
// A linear part worse than this is applied to the triangles instead of being inverted for the ray.
constexpr double kMaxCondition = 1e6;
constexpr double kDeterminantRounding = 0x1p-49;  // of its terms: 16 roundings, it takes 9

glm::dmat3 linearOf(const Instance& instance) {
  const auto& m = instance.world_from_mesh;
  return {m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]};
}

glm::dvec3 shiftOf(const Instance& instance) {
  const auto& m = instance.world_from_mesh;
  return {m[3], m[7], m[11]};
}

bool finite(const Instance& instance) {
  return std::all_of(instance.world_from_mesh.begin(), instance.world_from_mesh.end(),
                     [](double x) { return std::isfinite(x); });
}

double norm(const glm::dmat3& m) {
  return std::sqrt(glm::dot(m[0], m[0]) + glm::dot(m[1], m[1]) + glm::dot(m[2], m[2]));
}

bool invertible(const glm::dmat3& linear) {
  const double scale = norm(linear);
  if (!(scale > 0.0)) return false;
  const glm::dmat3 unit = linear / scale;
  return std::abs(glm::determinant(unit)) > 0.0 && norm(glm::inverse(unit)) < kMaxCondition;
}

/// By the sign of the determinant, if rounding cannot have decided it. A map that is flat because
/// entries are zero does not mirror.
Front frontUnder(const glm::dmat3& linear) {
  const double scale = norm(linear);
  if (!(scale > 0.0)) return Front::kCounterClockwise;
  const glm::dmat3 m = linear / scale;
  double sum = 0.0, terms = 0.0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double with = m[0][i] * m[1][j] * m[2][k], against = m[0][i] * m[1][k] * m[2][j];
    sum += with - against;
    terms += std::abs(with) + std::abs(against);
  }
  if (terms == 0.0) return Front::kCounterClockwise;
  if (!(std::abs(sum) > kDeterminantRounding * terms)) return Front::kUnknown;
  return sum < 0.0 ? Front::kClockwise : Front::kCounterClockwise;
}

}  // namespace

Result<std::unique_ptr<RayScene>> RayScene::build(SnapshotPtr scene) {
  std::unique_ptr<RayScene> built(new RayScene(std::move(scene)));
  const SceneSnapshot& snapshot = *built->scene_;
  built->device_.reset(rtcNewDevice(nullptr));
  if (!built->device_) return Error{ErrorCode::kUnavailable, "oracle: Embree does not start"};
  for (std::size_t i = 0; i < snapshot.meshCount(); ++i) {
    built->meshes_.push_back(nullptr);
  }
  parallelFor(snapshot.meshCount(), [&](std::size_t i) {
    built->meshes_[i] = std::make_unique<RayMesh>(snapshot.mesh(static_cast<MeshId>(i)));
  });
  built->flattened_.assign(snapshot.objectCount(), kNotFlattened);
  for (ObjectId id = 0; id < snapshot.objectCount(); ++id) built->flatten(id);
  bool enough_memory = true;  // Embree's own threads build each hierarchy
  for (const auto& mesh : built->meshes_) {
    enough_memory = enough_memory && mesh->buildHierarchy(built->device_.get());
  }
  if (!enough_memory) return Error{ErrorCode::kUnavailable, "oracle: Embree is out of memory"};
  return built;
}

void RayScene::flatten(ObjectId id) {
  const Instance& instance = scene_->instance(id);
  const glm::dmat3 linear = linearOf(instance);
  if (instance.removed || !finite(instance) || invertible(linear)) return;
  const glm::dvec3 extent = meshes_[instance.mesh]->halfExtent();
  if (linear * extent == glm::dvec3(0.0) && norm(linear) == 0.0) return;  // a point
  const Mesh& mesh = scene_->mesh(instance.mesh);
  std::vector<glm::dvec3> positions;
  positions.reserve(mesh.positions.size());
  for (const glm::vec3& p : mesh.positions) {
    positions.push_back(linear * glm::dvec3(p));
  }
  flattened_[id] = static_cast<std::uint32_t>(meshes_.size());
  meshes_.push_back(std::make_unique<RayMesh>(mesh, std::move(positions), frontUnder(linear)));
}

Placing RayScene::place(ObjectId id) const {
  const Instance& instance = scene_->instance(id);
  if (!instance.active() || !finite(instance)) return {};
  if (flattened_[id] != kNotFlattened) {
    const RayMesh* mesh = meshes_[flattened_[id]].get();
    if (!(mesh->radius() > 0.0)) return {};
    return {mesh, glm::dmat3(1.0), shiftOf(instance)};
  }
  const RayMesh* mesh = meshes_[instance.mesh].get();
  const glm::dmat3 linear = linearOf(instance);
  if (!(mesh->radius() > 0.0) || norm(linear) == 0.0) return {};
  return {mesh, linear, shiftOf(instance)};
}

}  // namespace culld::oracle
