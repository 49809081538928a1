#include "client/sdk/c_types.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <string>

namespace culld::client {
namespace {

std::uint32_t milliseconds(std::chrono::milliseconds time) {
  return static_cast<std::uint32_t>(time.count());
}

}  // namespace

culld_code codeOf(ErrorCode code) {
  switch (code) {
    case ErrorCode::kInvalidInput:
      return CULLD_INVALID_INPUT;
    case ErrorCode::kUnsupported:
      return CULLD_UNSUPPORTED;
    case ErrorCode::kNotFound:
      return CULLD_NOT_FOUND;
    case ErrorCode::kLimit:
      return CULLD_LIMIT;
    case ErrorCode::kIo:
      return CULLD_IO;
    case ErrorCode::kUnavailable:
      return CULLD_UNAVAILABLE;
    case ErrorCode::kForbidden:
      return CULLD_FORBIDDEN;
    case ErrorCode::kCancelled:
      return CULLD_CANCELLED;
    case ErrorCode::kDeadline:
      return CULLD_DEADLINE;
  }
  return CULLD_UNAVAILABLE;
}

culld_options defaultOptions() {
  const ConnectOptions d;
  culld_options o{};
  o.size = sizeof o;
  o.connect_ms = milliseconds(d.timeouts.connect);
  o.reply_ms = milliseconds(d.timeouts.reply);
  o.idle_ms = milliseconds(d.timeouts.idle);
  o.reconnect = d.reconnect.enabled ? 1 : 0;
  o.reconnect_first_ms = milliseconds(d.reconnect.first);
  o.reconnect_longest_ms = milliseconds(d.reconnect.longest);
  o.reconnect_factor = d.reconnect.factor;
  o.reconnect_jitter = d.reconnect.jitter;
  o.reconnect_max_attempts = d.reconnect.max_attempts;
  return o;
}

ConnectOptions optionsOf(const culld_options& o) {
  using Ms = std::chrono::milliseconds;
  ConnectOptions options;
  options.timeouts = {Ms(o.connect_ms), Ms(o.reply_ms), Ms(o.idle_ms)};
  options.reconnect = {o.reconnect != 0,   Ms(o.reconnect_first_ms), Ms(o.reconnect_longest_ms),
                       o.reconnect_factor, o.reconnect_jitter,       o.reconnect_max_attempts};
  if (o.token != nullptr) options.access.token = o.token;
  if (o.ca_file != nullptr) options.access.ca_file = o.ca_file;
  return options;
}

culld_camera defaultCamera() {
  const protocol::LookAt look;
  const Camera d;
  culld_camera c{};
  c.size = sizeof c;
  std::copy(look.eye.begin(), look.eye.end(), c.eye);
  std::copy(look.target.begin(), look.target.end(), c.target);
  std::copy(look.up.begin(), look.up.end(), c.up);
  c.yfov_rad = look.yfov_rad;
  c.aspect = look.aspect;
  c.znear_m = look.znear_m;
  for (const std::size_t i : {0U, 5U, 10U, 15U}) c.view[i] = c.projection[i] = 1.0;
  c.width_px = d.width_px;
  c.height_px = d.height_px;
  return c;
}

Result<Camera> cameraOf(const culld_camera* asked) {
  if (asked == nullptr) return protocol::invalidInput("camera: NULL");
  const culld_camera c = taken(asked, defaultCamera());
  Camera camera;
  if (c.kind == CULLD_LOOK_AT) {
    protocol::LookAt look;
    std::copy(std::begin(c.eye), std::end(c.eye), look.eye.begin());
    std::copy(std::begin(c.target), std::end(c.target), look.target.begin());
    std::copy(std::begin(c.up), std::end(c.up), look.up.begin());
    look.yfov_rad = c.yfov_rad;
    look.aspect = c.aspect;
    look.znear_m = c.znear_m;
    if (c.zfar_m != 0.0) look.zfar_m = c.zfar_m;
    camera.pose = look;
  } else if (c.kind == CULLD_MATRICES) {
    protocol::Matrices matrices;
    std::copy(std::begin(c.view), std::end(c.view), matrices.view.begin());
    std::copy(std::begin(c.projection), std::end(c.projection), matrices.projection.begin());
    camera.pose = matrices;
  } else {
    return protocol::invalidInput("camera.kind: " + std::to_string(c.kind));
  }
  camera.width_px = c.width_px;
  camera.height_px = c.height_px;
  camera.radius_m = c.radius_m;
  camera.angle_rad = c.angle_rad;
  return camera;
}

culld_demand defaultDemand() { return {sizeof(culld_demand), CULLD_CONSERVATIVE, 0.0F, 0.0F, 0}; }

Result<Demand> demandOf(const culld_demand* asked) {
  const culld_demand d = taken(asked, defaultDemand());
  if (d.guarantee < CULLD_CONSERVATIVE || d.guarantee > CULLD_APPROXIMATE) {
    return protocol::invalidInput("demand.guarantee: " + std::to_string(d.guarantee));
  }
  return Demand{static_cast<Guarantee>(d.guarantee), d.hole_px, d.accepted_missed_px, d.time_us};
}

culld_scene_info infoOf(const SceneInfo& scene) {
  culld_scene_info info{};
  info.size = sizeof info;
  info.version = scene.version;
  info.content_hash = scene.content_hash;
  info.triangles = scene.triangles;
  info.objects = scene.objects;
  return info;
}

Result<std::vector<EditItem>> editsOf(const culld_edit_item* items, std::size_t count) {
  std::vector<EditItem> edits(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (items[i].kind < CULLD_MOVE || items[i].kind > CULLD_ADD) {
      return protocol::invalidInput("edit " + std::to_string(i) +
                                    ": kind: " + std::to_string(items[i].kind));
    }
    edits[i].kind = static_cast<protocol::EditKind>(items[i].kind);
    edits[i].object = items[i].object;
    std::copy(std::begin(items[i].world_from_mesh), std::end(items[i].world_from_mesh),
              edits[i].world_from_mesh.begin());
  }
  return edits;
}

Result<std::vector<Place>> placesOf(const culld_place* places, std::size_t count) {
  if (places == nullptr && count > 0) return protocol::invalidInput("places: NULL");
  std::vector<Place> out(count);
  for (std::size_t i = 0; i < count; ++i) {
    std::copy_n(places[i].min, 3, out[i].min.begin());
    std::copy_n(places[i].max, 3, out[i].max.begin());
    out[i].radius_m = places[i].radius_m;
  }
  return out;
}

}  // namespace culld::client
