#include "culling/oracle/ray_mesh.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "culling/core/box.h"

namespace culld::oracle {
namespace {

// Fewer triangles than this are tried one by one.
constexpr std::uint32_t kMinHierarchy = 9;
// In units of the mesh's radius: what float rays and boxes may be off inside a mesh.
constexpr double kMeshSlack = 2e-6;
// Of the largest coordinate: two roundings to float.
constexpr double kFloatRounding = 0x1p-22;
constexpr double kDoubleRounding = 0x1p-50;
// Where a ray enters, in radii before the centre: outside of the mesh, rounding included.
constexpr double kEntry = 1.25;

double largest(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

bool finite(const glm::dvec3& v) {
  return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

}  // namespace

SceneHandle makePrimitives(RTCDevice device, unsigned count, void* user, RTCBoundsFunction bounds,
                           RTCIntersectFunctionN intersect) {
  SceneHandle scene(rtcNewScene(device));
  if (!scene) return nullptr;
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  if (geometry == nullptr) return nullptr;
  rtcSetGeometryUserPrimitiveCount(geometry, count);
  rtcSetGeometryUserData(geometry, user);
  rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
  rtcSetGeometryIntersectFunction(geometry, intersect);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene.get());
  if (rtcGetDeviceError(device) != RTC_ERROR_NONE) return nullptr;
  return scene;
}

void setBounds(RTCBounds& out, const glm::dvec3& low, const glm::dvec3& high) {
  const auto f = [](double x) { return static_cast<float>(x); };
  out.lower_x = f(low.x), out.lower_y = f(low.y), out.lower_z = f(low.z);
  out.upper_x = f(high.x), out.upper_y = f(high.y), out.upper_z = f(high.z);
}

bool castable(const RTCRay& ray) {
  constexpr float kMost = 1e18F;  // Embree's own limit is 1.8e18
  for (const float x :
       {ray.org_x, ray.org_y, ray.org_z, ray.dir_x, ray.dir_y, ray.dir_z, ray.tnear, ray.tfar}) {
    if (!(std::abs(x) < kMost)) return false;
  }
  return true;
}

double MeshTrace::limit() const { return blocked_at * (1.0 + kTieRelative) + tie; }

/// The context that Embree carries through a traversal, with our side of it.
struct RayMesh::Query : RTCIntersectContext {
  MeshTrace* trace = nullptr;
  std::vector<MeshHit>* hits = nullptr;
  glm::dvec3 entry{0.0};  // near the mesh, so that its floats are exact enough
  double entry_distance = 0.0;
};

RayMesh::RayMesh(const Mesh& mesh) : mesh_(&mesh) { measure(); }

RayMesh::RayMesh(const Mesh& mesh, std::vector<glm::dvec3> positions, Front front)
    : mesh_(&mesh), positions_(std::move(positions)), front_(front) {
  measure();
}

glm::dvec3 RayMesh::corner(std::uint32_t vertex) const {
  return positions_.empty() ? glm::dvec3(mesh_->positions[vertex]) : positions_[vertex];
}

Triangle RayMesh::triangle(std::uint32_t index) const {
  const auto& t = mesh_->triangles[index];
  return {corner(t[0]) - centre_, corner(t[1]) - centre_, corner(t[2]) - centre_};
}

std::uint32_t RayMesh::triangleCount() const {
  return static_cast<std::uint32_t>(mesh_->triangles.size());
}

const Surface& RayMesh::surfaceOf(std::uint32_t triangle) const {
  const auto after =
      std::upper_bound(mesh_->surfaces.begin(), mesh_->surfaces.end(), triangle,
                       [](std::uint32_t t, const Surface& s) { return t < s.first_triangle; });
  return *(after - 1);
}

void RayMesh::measure() {
  Box box;
  for (const auto& triangle : mesh_->triangles) {
    for (const std::uint32_t vertex : triangle) {
      if (finite(corner(vertex))) box.grow(corner(vertex));
    }
  }
  if (box.empty()) return;
  centre_ = 0.5 * box.min + 0.5 * box.max;
  half_extent_ = box.max - centre_;
  double squared = 0.0;
  area_up_to_.reserve(mesh_->triangles.size());
  double area = 0.0;
  for (std::uint32_t i = 0; i < triangleCount(); ++i) {
    const Triangle t = triangle(i);
    for (const glm::dvec3& p : t) {
      if (finite(p)) squared = std::max(squared, glm::dot(p, p));
    }
    const double doubled = glm::length(glm::cross(t[1] - t[0], t[2] - t[0]));
    if (std::isfinite(doubled)) area += doubled;
    area_up_to_.push_back(area);
  }
  radius_ = std::sqrt(squared);
  // Where the transform is applied already the file's floats are gone; the size stands for them.
  grow_ = positions_.empty() ? kFloatRounding * largest(glm::abs(centre_) + half_extent_)
                             : kFloatRounding * radius_ + kDoubleRounding * largest(centre_);
}

std::uint32_t RayMesh::triangleAtArea(double share) const {
  const auto at =
      std::upper_bound(area_up_to_.begin(), area_up_to_.end(), share * area_up_to_.back());
  const auto index = static_cast<std::uint32_t>(at - area_up_to_.begin());
  return std::min(index, triangleCount() - 1);
}

bool RayMesh::buildHierarchy(RTCDevice device) {
  if (!(radius_ > 0.0) || triangleCount() < kMinHierarchy) return true;
  hierarchy_ =
      makePrimitives(device, triangleCount(), this, &RayMesh::boundsOf, &RayMesh::intersect);
  return hierarchy_ != nullptr;
}

void RayMesh::boundsOf(const RTCBoundsFunctionArguments* args) {
  const auto* mesh = static_cast<const RayMesh*>(args->geometryUserPtr);
  Box box;
  for (const glm::dvec3& p : mesh->triangle(args->primID)) box.grow(p / mesh->radius_);
  setBounds(*args->bounds_o, box.min - kMeshSlack, box.max + kMeshSlack);
}

void RayMesh::meet(std::uint32_t index, Query& query) const {
  MeshTrace& trace = *query.trace;
  const auto hit = hitTriangle(query.entry, trace.direction, triangle(index), grow_);
  if (!hit) return;
  const double distance = query.entry_distance + hit->distance;
  if (!(distance >= trace.from && distance <= trace.limit())) return;
  const Surface& surface = surfaceOf(index);
  const bool side_known = surface.double_sided || front_ != Front::kUnknown;
  if (!surface.double_sided && side_known && hit->front == (front_ == Front::kClockwise)) return;
  if (hit->met && side_known) query.hits->push_back({distance, index});
  if (surface.blocks && trace.may_block) trace.blocked_at = std::min(trace.blocked_at, distance);
}

void RayMesh::intersect(const RTCIntersectFunctionNArguments* args) {
  const auto* mesh = static_cast<const RayMesh*>(args->geometryUserPtr);
  auto& query = *static_cast<Query*>(args->context);
  const double before = query.trace->blocked_at;
  mesh->meet(args->primID, query);
  if (query.trace->blocked_at == before) return;
  // REQUIRES of Embree: N is 1 for rays that come from rtcIntersect1.
  const double left = (query.trace->limit() - query.entry_distance) / mesh->radius_;
  float& far = RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, 1), 1, 0);
  far = std::min(far, static_cast<float>(left * (1.0 + kMeshSlack) + 2.0 * kMeshSlack));
}

void RayMesh::trace(MeshTrace& trace, std::vector<MeshHit>& hits) const {
  const double closest = -glm::dot(trace.origin, trace.direction);
  const glm::dvec3 miss = trace.origin + closest * trace.direction;
  const double reach = radius_ * (1.0 + kMeshSlack);
  if (!(glm::dot(miss, miss) <= reach * reach)) return;
  if (closest + reach < trace.from || closest - reach > trace.limit()) return;
  Query query;
  rtcInitIntersectContext(&query);
  query.trace = &trace;
  query.hits = &hits;
  query.entry_distance = closest - kEntry * radius_;
  query.entry = trace.origin + query.entry_distance * trace.direction;
  const auto f = [](double x) { return static_cast<float>(x); };
  RTCRayHit ray{};
  ray.ray.org_x = f(query.entry.x / radius_);
  ray.ray.org_y = f(query.entry.y / radius_);
  ray.ray.org_z = f(query.entry.z / radius_);
  ray.ray.dir_x = f(trace.direction.x);
  ray.ray.dir_y = f(trace.direction.y);
  ray.ray.dir_z = f(trace.direction.z);
  const double near = (trace.from - query.entry_distance) / radius_ - 2.0 * kMeshSlack;
  const double far = (trace.limit() - query.entry_distance) / radius_ + 2.0 * kMeshSlack;
  ray.ray.tnear = f(std::clamp(near, 0.0, 4.0));
  ray.ray.tfar = f(std::clamp(far, 0.0, 4.0));
  ray.ray.mask = ~0U;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  if (hierarchy_ && castable(ray.ray)) {
    rtcIntersect1(hierarchy_.get(), &query, &ray);
  } else {
    for (std::uint32_t i = 0; i < triangleCount(); ++i) meet(i, query);
  }
}

}  // namespace culld::oracle
