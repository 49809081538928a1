// The C functions of culld/client.h over the C++ SDK. Nothing is thrown across them.
#include <algorithm>
#include <cstring>
#include <exception>
#include <functional>
#include <memory>
#include <new>
#include <string>
#include <type_traits>
#include <utility>

#include "culld/client.h"
#include "culld/connection.h"

using namespace culld::client;  // NOLINT(google-build-using-namespace): not a header

struct culld_connection {
  std::unique_ptr<Connection> connection;
};
struct culld_view {
  View view;
};
struct culld_frame {
  FramePtr frame;
};

namespace {

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

culld_code tell(culld_error* error, culld_code code, const char* message) {
  if (error == nullptr) return code;
  error->code = code;
  const std::size_t length = std::min(std::strlen(message), sizeof(error->message) - 1);
  std::memcpy(error->message, message, length);
  error->message[length] = '\0';
  return code;
}

culld_code tell(culld_error* error, const Error& what) {
  return tell(error, codeOf(what.code), what.message.c_str());
}

/// What `task` returns, or a code for what it throws: memory or threads that are not there.
template <typename Task>
culld_code guarded(culld_error* error, Task task) noexcept {
  try {
    return task();
  } catch (const std::bad_alloc&) {
    return tell(error, CULLD_NO_MEMORY, "out of memory");
  } catch (const std::exception& thrown) {
    return tell(error, CULLD_UNAVAILABLE, thrown.what());
  }
}

template <typename Task>
void guarded(Task task) noexcept {
  guarded(nullptr, [&task] {
    task();
    return CULLD_OK;
  });
}

/// As much of a struct as both sides know. REQUIRES: its first member is its size.
template <typename T>
T taken(const T* given, const T& defaults) {
  static_assert(std::is_trivially_copyable_v<T> && offsetof(T, size) == 0);
  T known = defaults;
  if (given == nullptr) return known;
  std::memcpy(&known, given, std::min(given->size, sizeof(T)));
  return known;
}

template <typename T>
void given(T* target, std::size_t size, T source) {
  if (target == nullptr) return;
  source.size = std::min(size, sizeof(T));
  std::memcpy(target, &source, source.size);
}

std::uint32_t milliseconds(std::chrono::milliseconds time) {
  return static_cast<std::uint32_t>(time.count());
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
  const culld::protocol::LookAt look;
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

/// ERROR: kInvalidInput: of no kind.
Result<Camera> cameraOf(const culld_camera* asked) {
  if (asked == nullptr) return culld::protocol::invalidInput("camera: NULL");
  const culld_camera c = taken(asked, defaultCamera());
  Camera camera;
  if (c.kind == CULLD_LOOK_AT) {
    culld::protocol::LookAt look;
    std::copy(std::begin(c.eye), std::end(c.eye), look.eye.begin());
    std::copy(std::begin(c.target), std::end(c.target), look.target.begin());
    std::copy(std::begin(c.up), std::end(c.up), look.up.begin());
    look.yfov_rad = c.yfov_rad;
    look.aspect = c.aspect;
    look.znear_m = c.znear_m;
    if (c.zfar_m != 0.0) look.zfar_m = c.zfar_m;
    camera.pose = look;
  } else if (c.kind == CULLD_MATRICES) {
    culld::protocol::Matrices matrices;
    std::copy(std::begin(c.view), std::end(c.view), matrices.view.begin());
    std::copy(std::begin(c.projection), std::end(c.projection), matrices.projection.begin());
    camera.pose = matrices;
  } else {
    return culld::protocol::invalidInput("camera.kind: " + std::to_string(c.kind));
  }
  camera.width_px = c.width_px;
  camera.height_px = c.height_px;
  camera.radius_m = c.radius_m;
  camera.angle_rad = c.angle_rad;
  return camera;
}

/// ERROR: kInvalidInput: no such guarantee.
Result<Demand> demandOf(const culld_demand* asked) {
  const culld_demand d = taken(asked, culld_demand{sizeof(culld_demand), 0, 0.0F, 0.0F, 0});
  if (d.guarantee < CULLD_CONSERVATIVE || d.guarantee > CULLD_APPROXIMATE) {
    return culld::protocol::invalidInput("demand.guarantee: " + std::to_string(d.guarantee));
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

/// ERROR: kInvalidInput: of no kind.
Result<std::vector<EditItem>> editsOf(const culld_edit_item* items, std::size_t count) {
  std::vector<EditItem> edits(count);
  for (std::size_t i = 0; i < count; ++i) {
    if (items[i].kind < CULLD_MOVE || items[i].kind > CULLD_ADD) {
      return culld::protocol::invalidInput("edit " + std::to_string(i) +
                                           ": kind: " + std::to_string(items[i].kind));
    }
    edits[i].kind = static_cast<culld::protocol::EditKind>(items[i].kind);
    edits[i].object = items[i].object;
    std::copy(std::begin(items[i].world_from_mesh), std::end(items[i].world_from_mesh),
              edits[i].world_from_mesh.begin());
  }
  return edits;
}

void passOn(culld_on_answer callback, void* user, const Result<FramePtr>& answer) {
  culld_error error{};
  if (!answer) {
    tell(&error, answer.error());
    return callback(user, nullptr, &error);
  }
  const culld_frame frame{answer.value()};
  callback(user, &frame, &error);
}

const char* orEmpty(const char* text) { return text == nullptr ? "" : text; }

}  // namespace

uint32_t culld_client_abi(void) { return CULLD_CLIENT_ABI; }

const char* culld_client_version(void) { return CULLD_VERSION; }

void culld_options_init(culld_options* options, size_t size) {
  given(options, size, defaultOptions());
}

culld_code culld_connect(const char* address, const char* scene, const culld_options* options,
                         culld_connection** connection, culld_error* error) {
  return guarded(error, [&]() -> culld_code {
    if (connection == nullptr) return tell(error, CULLD_INVALID_INPUT, "connection: NULL");
    *connection = nullptr;
    const auto where = parseAddress(orEmpty(address));
    if (!where) return tell(error, where.error());
    auto opened = Connection::open(where.value(), orEmpty(scene),
                                   optionsOf(taken(options, defaultOptions())));
    if (!opened) return tell(error, opened.error());
    *connection = new culld_connection{std::move(opened).value()};
    return tell(error, CULLD_OK, "");
  });
}

void culld_connection_close(culld_connection* connection) {
  if (connection != nullptr) guarded([&] { connection->connection->close(); });
}

void culld_connection_free(culld_connection* connection) {
  guarded([&] { delete connection; });
}

int32_t culld_connection_state(const culld_connection* connection) {
  return static_cast<int32_t>(connection->connection->state());
}

void culld_connection_on_state(culld_connection* connection, culld_on_state callback, void* user) {
  guarded([&] {
    if (callback == nullptr) return connection->connection->onState({});
    connection->connection->onState([=](ConnectionState state, const Error& reason) {
      culld_error error{};
      if (state != ConnectionState::kConnected) tell(&error, reason);
      callback(user, static_cast<int32_t>(state), &error);
    });
  });
}

void culld_connection_scene(const culld_connection* connection, culld_scene_info* info,
                            size_t size) {
  guarded([&] { given(info, size, infoOf(connection->connection->scene())); });
}

void culld_connection_on_scene(culld_connection* connection, culld_on_scene callback, void* user) {
  guarded([&] {
    if (callback == nullptr) return connection->connection->onSceneChanged({});
    connection->connection->onSceneChanged([=](const SceneInfo& scene, bool replaced) {
      const culld_scene_info info = infoOf(scene);
      callback(user, &info, replaced ? 1 : 0);
    });
  });
}

culld_code culld_ping(culld_connection* connection, uint64_t* round_trip_ns, culld_error* error) {
  return guarded(error, [&]() -> culld_code {
    const auto time = connection->connection->ping();
    if (!time) return tell(error, time.error());
    if (round_trip_ns != nullptr) {
      *round_trip_ns = static_cast<std::uint64_t>(time.value().count());
    }
    return tell(error, CULLD_OK, "");
  });
}

culld_code culld_edit(culld_connection* connection, const culld_edit_item* items, size_t count,
                      uint64_t expected_version, uint64_t* version, uint32_t* added,
                      size_t added_capacity, size_t* added_count, culld_error* error) {
  return guarded(error, [&]() -> culld_code {
    auto edits = editsOf(items, count);
    if (!edits) return tell(error, edits.error());
    const auto outcome = connection->connection->edit(std::move(edits).value(), expected_version);
    if (!outcome) return tell(error, outcome.error());
    const auto& ids = outcome.value().added;
    if (version != nullptr) *version = outcome.value().scene_version;
    if (added != nullptr) std::copy_n(ids.begin(), std::min(ids.size(), added_capacity), added);
    if (added_count != nullptr) *added_count = ids.size();
    return tell(error, CULLD_OK, "");
  });
}

void culld_camera_init(culld_camera* camera, size_t size) { given(camera, size, defaultCamera()); }

void culld_demand_init(culld_demand* demand, size_t size) {
  given(demand, size, culld_demand{sizeof(culld_demand), CULLD_CONSERVATIVE, 0.0F, 0.0F, 0});
}

culld_code culld_open_view(culld_connection* connection, const char* method, int32_t want_seen,
                           culld_view** view, culld_error* error) {
  return guarded(error, [&]() -> culld_code {
    if (view == nullptr) return tell(error, CULLD_INVALID_INPUT, "view: NULL");
    *view = nullptr;
    auto opened = connection->connection->openView(orEmpty(method), want_seen != 0);
    if (!opened) return tell(error, opened.error());
    *view = new culld_view{std::move(opened).value()};
    return tell(error, CULLD_OK, "");
  });
}

void culld_view_free(culld_view* view) {
  guarded([&] { delete view; });
}

culld_code culld_cull(culld_view* view, const culld_camera* camera, const culld_demand* demand,
                      culld_frame** frame, culld_error* error) {
  return guarded(error, [&]() -> culld_code {
    if (frame == nullptr) return tell(error, CULLD_INVALID_INPUT, "frame: NULL");
    *frame = nullptr;
    const auto seen_from = cameraOf(camera);
    if (!seen_from) return tell(error, seen_from.error());
    const auto wanted = demandOf(demand);
    if (!wanted) return tell(error, wanted.error());
    auto answer = view->view.cull(seen_from.value(), wanted.value());
    if (!answer) return tell(error, answer.error());
    *frame = new culld_frame{std::move(answer).value()};
    return tell(error, CULLD_OK, "");
  });
}

uint64_t culld_set_camera(culld_view* view, const culld_camera* camera, const culld_demand* demand,
                          culld_on_answer callback, void* user) {
  std::uint64_t number = 0;
  guarded([&] {
    const auto seen_from = cameraOf(camera);
    const auto wanted = demandOf(demand);
    if (!seen_from || !wanted) {
      const Error& error = seen_from ? wanted.error() : seen_from.error();
      if (callback != nullptr) passOn(callback, user, error);
      return;
    }
    number = view->view.setCamera(seen_from.value(), wanted.value(),
                                  [=](const Result<FramePtr>& answer) {
                                    if (callback != nullptr) passOn(callback, user, answer);
                                  });
  });
  return number;
}

void culld_view_on_frame(culld_view* view, culld_on_frame callback, void* user) {
  guarded([&] {
    if (callback == nullptr) return view->view.onFrame({});
    view->view.onFrame([=](const FramePtr& answer) {
      const culld_frame frame{answer};
      callback(user, &frame);
    });
  });
}

void culld_view_set_deadline(culld_view* view, uint32_t deadline_us) {
  guarded([&] { view->view.setDeadline(std::chrono::microseconds(deadline_us)); });
}

void culld_view_cancel(culld_view* view) {
  guarded([&] { view->view.cancel(); });
}

void culld_frame_get_info(const culld_frame* frame, culld_frame_info* info, size_t size) {
  const Frame& f = *frame->frame;
  culld_frame_info i{};
  i.camera = f.camera;
  i.scene_version = f.scene_version;
  i.cull_ns = f.stats.cull_ns;
  i.scene_objects = f.scene_objects;
  i.seen_count = f.seen_count;
  i.kept_count = f.kept_count;
  i.superseded = f.superseded;
  i.guarantee = static_cast<int32_t>(f.guarantee);
  i.proven = f.proven ? 1 : 0;
  i.out_of_budget = f.out_of_budget ? 1 : 0;
  i.delta = f.delta ? 1 : 0;
  i.missed_px = f.missed_px;
  given(info, size, i);
}

const uint32_t* culld_frame_ids(const culld_frame* frame, size_t* count) {
  if (count != nullptr) *count = frame->frame->visible.size();
  return frame->frame->visible.data();
}

const uint8_t* culld_frame_seen(const culld_frame* frame) {
  return frame->frame->seen.empty() ? nullptr : frame->frame->seen.data();
}

culld_frame* culld_frame_keep(const culld_frame* frame) {
  return new (std::nothrow) culld_frame{frame->frame};
}

void culld_frame_free(culld_frame* frame) { delete frame; }
