#include "server/translate.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/type_ptr.hpp>

namespace culld::server {
namespace {

glm::dvec3 vec3(const std::array<double, 3>& v) { return {v[0], v[1], v[2]}; }

Edit toEngineEdit(const protocol::EditItem& item) {
  switch (item.kind) {
    case protocol::EditKind::kMove:
      return MoveObject{item.object, item.world_from_mesh};
    case protocol::EditKind::kHide:
      return HideObject{item.object};
    case protocol::EditKind::kShow:
      return ShowObject{item.object};
    case protocol::EditKind::kRemove:
      return RemoveObject{item.object};
    case protocol::EditKind::kAdd:
      break;
  }
  return AddInstance{item.object, item.world_from_mesh};
}

}  // namespace

Result<Camera> toEngine(const protocol::Camera& camera) {
  const ImageSize image{camera.width_px, camera.height_px};
  const MotionBound motion{camera.radius_m, camera.angle_rad};
  if (const auto* m = std::get_if<protocol::Matrices>(&camera.pose)) {
    return cameraFromMatrices(glm::make_mat4(m->view.data()), glm::make_mat4(m->projection.data()),
                              image, motion);
  }
  const auto& l = *std::get_if<protocol::LookAt>(&camera.pose);
  LookAt look;
  look.eye = vec3(l.eye);
  look.target = vec3(l.target);
  look.up = vec3(l.up);
  look.yfov_rad = l.yfov_rad;
  look.aspect = l.aspect;
  look.znear_m = l.znear_m;
  look.zfar_m = l.zfar_m;
  return cameraFromLookAt(look, image, motion);
}

Result<Demand> toEngine(const protocol::Demand& demand) {
  if (!std::isfinite(demand.hole_px) || demand.hole_px < 0.0F) {
    return invalidInput("demand.hole_px is not a number >= 0");
  }
  if (!std::isfinite(demand.accepted_missed_px) || demand.accepted_missed_px < 0.0F) {
    return invalidInput("demand.accepted_missed_px is not a number >= 0");
  }
  Demand out;
  out.guarantee = static_cast<Guarantee>(demand.guarantee);
  out.hole_px = demand.hole_px;
  out.accepted_missed_px = demand.accepted_missed_px;
  out.time = std::chrono::microseconds(demand.time_us);
  return out;
}

std::vector<Place> toEngine(std::span<const protocol::Place> places) {
  std::vector<Place> out;
  out.reserve(places.size());
  for (const protocol::Place& p : places) {
    out.push_back({{{p.min[0], p.min[1], p.min[2]}, {p.max[0], p.max[1], p.max[2]}}, p.radius_m});
  }
  return out;
}

std::vector<Edit> toEngine(std::span<const protocol::EditItem> edits) {
  std::vector<Edit> out;
  out.reserve(edits.size());
  for (const protocol::EditItem& item : edits) out.push_back(toEngineEdit(item));
  return out;
}

protocol::Guarantee toWire(Guarantee guarantee) noexcept {
  return static_cast<protocol::Guarantee>(guarantee);
}

protocol::Stats toWire(const CullStats& stats, std::chrono::nanoseconds queued) {
  protocol::Stats out;
  out.cull_ns = static_cast<std::uint64_t>(stats.time.count());
  out.queue_ns = static_cast<std::uint64_t>(std::max<std::int64_t>(0, queued.count()));
  out.nodes_visited = stats.nodes_visited;
  out.tested = stats.tested;
  out.outside = stats.outside;
  out.occluded = stats.occluded;
  out.in_frustum = stats.in_frustum;
  out.always_kept = stats.always_kept;
  out.occluders_drawn = stats.occluders_drawn;
  out.triangles_drawn = stats.triangles_drawn;
  return out;
}

protocol::WireCode toWire(ErrorCode code, protocol::WireCode invalid) noexcept {
  switch (code) {
    case ErrorCode::kInvalidInput:
      return invalid;
    case ErrorCode::kUnsupported:
      return protocol::WireCode::kUnsupported;
    case ErrorCode::kNotFound:
      return invalid;
    case ErrorCode::kLimit:
      return protocol::WireCode::kLimitExceeded;
    case ErrorCode::kIo:
      return protocol::WireCode::kInternal;
    case ErrorCode::kUnavailable:
      break;
  }
  return protocol::WireCode::kUnavailable;
}

protocol::SceneInfo describe(const std::string& name, const SceneSnapshot& scene) {
  return {name, scene.version(), scene.contentHash(),
          static_cast<std::uint32_t>(scene.objectCount()), scene.triangleCount()};
}

std::vector<std::uint8_t> packBits(std::span<const std::uint8_t> flags) {
  std::vector<std::uint8_t> out((flags.size() + 7) / 8);
  for (std::size_t i = 0; i < flags.size(); ++i) {
    if (flags[i] != 0) out[i / 8] = static_cast<std::uint8_t>(out[i / 8] | (1U << (i % 8)));
  }
  return out;
}

// The enumerators are cast, not mapped one by one.
static_assert(static_cast<int>(Guarantee::kConservative) ==
              static_cast<int>(protocol::Guarantee::kConservative));
static_assert(static_cast<int>(Guarantee::kHole) == static_cast<int>(protocol::Guarantee::kHole));
static_assert(static_cast<int>(Guarantee::kSampled) ==
              static_cast<int>(protocol::Guarantee::kSampled));
static_assert(static_cast<int>(Guarantee::kApproximate) ==
              static_cast<int>(protocol::Guarantee::kApproximate));

}  // namespace culld::server
