// `cullctl watch`: a line for every change of a scene, and for the connection's comings and goings.
#include <chrono>
#include <condition_variable>
#include <deque>
#include <iostream>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "client/cli/commands.h"
#include "culld/connection.h"
#include "protocol/text.h"

namespace culld::client {
namespace {

using nlohmann::json;

struct Event {
  const char* what = "";  ///< scene, edited, replaced, reconnecting, connected, ended
  SceneInfo scene;
  Error reason;
};

/// From the connection's thread to the one that prints.
class Events {
 public:
  void push(Event event) {
    const std::lock_guard lock(mutex_);
    waiting_.push_back(std::move(event));
    more_.notify_one();
  }
  Event next() {
    std::unique_lock lock(mutex_);
    more_.wait(lock, [this] { return !waiting_.empty(); });
    Event event = std::move(waiting_.front());
    waiting_.pop_front();
    return event;
  }

 private:
  std::mutex mutex_;
  std::condition_variable more_;
  std::deque<Event> waiting_;
};

const char* nameOf(ConnectionState state) {
  switch (state) {
    case ConnectionState::kConnected:
      return "connected";
    case ConnectionState::kReconnecting:
      return "reconnecting";
    case ConnectionState::kEnded:
      break;
  }
  return "ended";
}

bool aboutScene(const Event& event) { return event.reason.message.empty(); }

void print(const Event& event, bool as_json) {
  if (as_json) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    json line{{"event", event.what},
              {"scene", event.scene.name},
              {"time_s", std::chrono::duration<double>(now).count()}};
    if (aboutScene(event)) {
      line["version"] = event.scene.version;
      line["objects"] = event.scene.objects;
      line["triangles"] = event.scene.triangles;
    } else {
      line["reason"] = event.reason.message;
    }
    std::cout << line.dump(-1, ' ', false, json::error_handler_t::replace) << '\n';
  } else if (aboutScene(event)) {
    std::cout << event.scene.name << ": " << event.what << ", version " << event.scene.version
              << ", " << event.scene.objects << " objects, " << event.scene.triangles
              << " triangles\n";
  } else {
    std::cout << event.scene.name << ": " << event.what << ": "
              << protocol::oneLine(event.reason.message) << '\n';
  }
}

}  // namespace

int runWatch(const Server& server, const WatchArguments& arguments) {
  ConnectOptions options;
  options.access = server.access;
  Events events;  // outlives the connection, which calls into it
  auto opened = Connection::open(server.address, arguments.scene, options);
  if (!opened) return fail(opened.error());
  Connection& connection = *opened.value();
  connection.onSceneChanged([&events](const SceneInfo& scene, bool replaced) {
    events.push({replaced ? "replaced" : "edited", scene, {}});
  });
  connection.onState([&](ConnectionState state, const Error& reason) {
    SceneInfo scene = connection.scene();
    scene.name = arguments.scene;
    events.push({nameOf(state), std::move(scene), reason});
  });
  events.push({"scene", connection.scene(), {}});
  for (std::uint32_t printed = 0; arguments.count == 0 || printed < arguments.count; ++printed) {
    const Event event = events.next();
    if (connection.state() == ConnectionState::kEnded && event.what == std::string_view("ended")) {
      return fail(event.reason);
    }
    print(event, arguments.json);
    if (const auto written = protocol::flushStdout(); !written) {
      return fail(kDisk, written.error().message);
    }
  }
  return kFine;
}

}  // namespace culld::client
