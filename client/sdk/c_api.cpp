// The C functions of culld/client.h over the C++ SDK. Nothing is thrown across them.
#include <algorithm>
#include <cstring>
#include <exception>
#include <memory>
#include <new>
#include <utility>

#include "client/sdk/c_types.h"

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

culld_code culld_pairs(culld_connection* connection, const culld_place* viewers,
                       size_t viewer_count, const culld_place* targets, size_t target_count,
                       uint32_t time_us, uint8_t* may_see, uint64_t* version, culld_error* error) {
  return guarded(error, [&]() -> culld_code {
    auto from = placesOf(viewers, viewer_count);
    if (!from) return tell(error, from.error());
    auto to = placesOf(targets, target_count);
    if (!to) return tell(error, to.error());
    if (may_see == nullptr) return tell(error, CULLD_INVALID_INPUT, "may_see: NULL");
    const auto outcome = connection->connection->pairs(
        std::move(from).value(), std::move(to).value(), std::chrono::microseconds(time_us));
    if (!outcome) return tell(error, outcome.error());
    std::copy(outcome.value().bits.begin(), outcome.value().bits.end(), may_see);
    if (version != nullptr) *version = outcome.value().scene_version;
    return tell(error, CULLD_OK, "");
  });
}

void culld_camera_init(culld_camera* camera, size_t size) { given(camera, size, defaultCamera()); }

void culld_demand_init(culld_demand* demand, size_t size) { given(demand, size, defaultDemand()); }

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
