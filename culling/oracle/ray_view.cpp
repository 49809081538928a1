#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

#include "culling/oracle/ray_scene.h"

namespace culld::oracle {
namespace {

// Relative: surfaces no farther apart than this are at the same depth, rounding being what it is.
constexpr double kSameDepth = 1e-12;
constexpr double kDoubleRounding = 0x1p-50;
// Relative to a box's distance: what Embree's float rays and boxes may be off.
constexpr double kFloatSlack = 2e-6;

double largest(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

}  // namespace

struct RayView::Query : RTCIntersectContext {
  const RayView* view = nullptr;
  const Ray* ray = nullptr;
  double float_per_t = 1.0;  // Embree's distances per t
  double blocked_at = std::numeric_limits<double>::infinity();
  Hits* hits = nullptr;
};

Result<std::unique_ptr<RayView>> RayView::build(const RayScene& scene, const Camera& camera) {
  std::unique_ptr<RayView> view(new RayView(camera));
  view->placeObjects(scene, camera);
  double reach = view->rays_.originReach();
  for (const Placed& placed : view->placed_) reach = std::max(reach, placed.size);
  view->unit_m_ = reach > 0.0 ? reach : 1.0;
  if (view->placed_.empty()) return view;
  view->hierarchy_ = makePrimitives(scene.device(), static_cast<unsigned>(view->placed_.size()),
                                    view.get(), &RayView::boundsOf, &RayView::intersect);
  if (!view->hierarchy_) return Error{ErrorCode::kUnavailable, "oracle: Embree is out of memory"};
  return view;
}

void RayView::placeObjects(const RayScene& scene, const Camera& camera) {
  const SceneSnapshot& snapshot = scene.snapshot();
  for (ObjectId id = 0; id < snapshot.objectCount(); ++id) {
    const Placing placing = scene.place(id);
    if (placing.mesh == nullptr) continue;
    Placed placed;
    placed.object = id;
    placed.mesh = placing.mesh;
    placed.world_from_mesh = placing.linear;
    placed.centre =
        placing.linear * placing.mesh->centre() + (placing.shift_world - camera.origin_world);
    double extent = 0.0;
    for (int i = 0; i < 3; ++i) {
      placed.axes[static_cast<std::size_t>(i)] = placing.linear[i] * placing.mesh->halfExtent()[i];
      extent += largest(placed.axes[static_cast<std::size_t>(i)]);
    }
    placed.size = largest(placed.centre) + extent;
    if (!std::isfinite(placed.size) || rays_.outside(placed.centre, placed.axes)) continue;
    placed.may_block = !snapshot.instance(id).always_kept;
    placed.mesh_from_world = glm::inverse(placing.linear);
    placed.rounding_m = kDoubleRounding *
                        (largest(camera.origin_world) + largest(placing.shift_world) + placed.size);
    placed_.push_back(placed);
  }
}

void RayView::boundsOf(const RTCBoundsFunctionArguments* args) {
  const auto* view = static_cast<const RayView*>(args->geometryUserPtr);
  const Placed& placed = view->placed_[args->primID];
  glm::dvec3 half(kFloatSlack * (placed.size + view->rays_.originReach()));
  for (const glm::dvec3& axis : placed.axes) half += glm::abs(axis);
  setBounds(*args->bounds_o, (placed.centre - half) / view->unit_m_,
            (placed.centre + half) / view->unit_m_);
}

double RayView::limit(double blocked_at) const {
  return blocked_at * (1.0 + kTieRelative) + (rays_.perspective() ? 0.0 : kTieRelative);
}

void RayView::enter(std::uint32_t index, Query& query) const {
  const Placed& placed = placed_[index];
  const glm::dvec3 direction = placed.mesh_from_world * query.ray->direction;
  const double per_t = glm::length(direction);
  MeshTrace trace;
  trace.origin = placed.mesh_from_world * (query.ray->origin - placed.centre);
  trace.direction = direction / per_t;
  trace.from = query.ray->t_min * per_t;
  trace.blocked_at = query.blocked_at * per_t;
  trace.tie = rays_.perspective() ? 0.0 : kTieRelative * per_t;
  trace.may_block = placed.may_block;
  query.hits->in_mesh.clear();
  const double before = trace.blocked_at;
  placed.mesh->trace(trace, query.hits->in_mesh);
  for (const MeshHit& hit : query.hits->in_mesh) {
    const double t = hit.distance / per_t;
    if (t > query.ray->t_min && t < query.ray->t_max) {
      query.hits->found.push_back({t, index, hit.triangle, false});
    }
  }
  if (trace.blocked_at < before) query.blocked_at = trace.blocked_at / per_t;
}

void RayView::intersect(const RTCIntersectFunctionNArguments* args) {
  const auto* view = static_cast<const RayView*>(args->geometryUserPtr);
  auto& query = *static_cast<Query*>(args->context);
  const double before = query.blocked_at;
  view->enter(args->primID, query);
  if (query.blocked_at == before) return;
  const double far_t = view->limit(query.blocked_at) * (1.0 + kTieRelative);
  float& far = RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, 1), 1, 0);
  far = std::min(far, static_cast<float>(far_t * query.float_per_t));
}

void RayView::trace(const Ray& ray, Hits& hits) const {
  hits.found.clear();
  if (!hierarchy_) return;
  const double length = glm::length(ray.direction);
  Query query;
  rtcInitIntersectContext(&query);
  query.view = this;
  query.ray = &ray;
  query.float_per_t = length / unit_m_;
  query.hits = &hits;
  const auto f = [](double x) { return static_cast<float>(x); };
  RTCRayHit embree{};
  embree.ray.org_x = f(ray.origin.x / unit_m_);
  embree.ray.org_y = f(ray.origin.y / unit_m_);
  embree.ray.org_z = f(ray.origin.z / unit_m_);
  embree.ray.dir_x = f(ray.direction.x / length);
  embree.ray.dir_y = f(ray.direction.y / length);
  embree.ray.dir_z = f(ray.direction.z / length);
  // Everything is within 4 units of the origin.
  embree.ray.tnear = f(std::clamp(ray.t_min * (1.0 - kTieRelative) * query.float_per_t, 0.0, 4.0));
  embree.ray.tfar = f(std::clamp(ray.t_max * (1.0 + kTieRelative) * query.float_per_t, 0.0, 4.0));
  embree.ray.mask = ~0U;
  embree.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  if (castable(embree.ray)) {
    rtcIntersect1(hierarchy_.get(), &query, &embree);
  } else {
    for (std::uint32_t i = 0; i < placed_.size(); ++i) enter(i, query);
  }

  const double last_tie = limit(query.blocked_at);
  std::erase_if(hits.found, [&](const Hit& hit) { return hit.t > last_tie; });
  for (Hit& hit : hits.found) {
    const double same =
        query.blocked_at * (1.0 + kSameDepth) + placed_[hit.placed].rounding_m / length;
    hit.tie = hit.t > same;
  }
}

}  // namespace culld::oracle
