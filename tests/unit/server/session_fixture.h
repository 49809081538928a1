// A session with a test in the place of its client, its workers and its socket.
#pragma once
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "protocol/codec.h"
#include "server/session.h"
#include "tests/unit/server/fake_method.h"

namespace culld::server {

namespace wire = protocol;

class TestClock : public Clock {
 public:
  Time time{0};
  Time now() const noexcept override { return time; }
};

inline wire::Camera cameraAt(double x) {
  wire::LookAt look;
  look.eye = {x, 0, 5};
  look.target = {x, 0, 0};
  wire::Camera camera;
  camera.pose = look;
  return camera;
}

/// Plays client, workers and socket for one session.
class SessionTest : public ::testing::Test {
 protected:
  void say(wire::Body body, std::uint64_t id = 0) {
    absorb(session.receive(wire::encode({id, std::move(body)}), clock.time));
  }
  void hello() {
    say(wire::Hello{1, 1, "test"}, 1);
    ASSERT_EQ(count<wire::Welcome>(), 1U);
    inbox.clear();
  }
  void open(std::uint32_t view, const std::string& method = "") {
    say(wire::OpenView{view, method, false}, 2);
  }
  void camera(double x, std::uint64_t id, std::uint32_t ack = 0, std::uint32_t view = 1) {
    say(wire::CameraUpdate{view, cameraAt(x), {}, ack}, id);
  }
  void absorb(Actions actions) {
    for (Action& action : actions) {
      if (auto* send = std::get_if<Send>(&action)) {
        auto message = wire::decode(send->bytes, wire::kMaxReplyBytes);
        ASSERT_TRUE(message.ok()) << message.error().message;
        inbox.push_back(std::move(message).value());
        unsent.push_back(send->tag);
      } else if (auto* cull = std::get_if<StartCull>(&action)) {
        culls.push_back(std::move(cull->job));
      } else if (auto* edit = std::get_if<StartEdit>(&action)) {
        edits.push_back(std::move(edit->job));
      } else if (auto* question = std::get_if<StartPairs>(&action)) {
        pairs.push_back(std::move(question->job));
      } else {
        closed = std::get<Close>(action);
      }
    }
  }
  void runCulls() {
    auto jobs = std::exchange(culls, {});
    for (CullJob& job : jobs) absorb(session.culled(runCull(std::move(job), clock)));
  }
  void runPairs() {
    auto jobs = std::exchange(pairs, {});
    for (PairsJob& job : jobs) absorb(session.paired(server::runPairs(std::move(job), clock)));
  }
  void runEdits() {
    auto jobs = std::exchange(edits, {});
    for (EditDone& done : server::runEdits(*scene, jobs)) absorb(session.edited(std::move(done)));
  }
  void flush() {
    while (!unsent.empty()) {
      auto tags = std::exchange(unsent, {});
      for (const SendTag& tag : tags) absorb(session.sent(tag));
    }
  }
  /// Until nothing is left to do.
  void settle() {
    while (!culls.empty() || !edits.empty() || !unsent.empty()) {
      runEdits();
      runCulls();
      flush();
    }
  }
  template <typename T>
  std::size_t count() const {
    return static_cast<std::size_t>(std::count_if(inbox.begin(), inbox.end(), [](const auto& m) {
      return std::holds_alternative<T>(m.body);
    }));
  }
  template <typename T>
  const T& last() const {
    for (auto m = inbox.rbegin(); m != inbox.rend(); ++m) {
      if (std::holds_alternative<T>(m->body)) return std::get<T>(m->body);
    }
    ADD_FAILURE() << "no such message came";
    static const T kNone{};
    return kNone;
  }
  void expectError(wire::WireCode code, const std::string& words) {
    ASSERT_FALSE(inbox.empty());
    const auto* error = std::get_if<wire::ErrorReply>(&inbox.back().body);
    ASSERT_NE(error, nullptr);
    EXPECT_EQ(error->code, code) << error->message;
    EXPECT_NE(error->message.find(words), std::string::npos) << error->message;
  }

  FakeMethod fake;
  const Method* table[1] = {&fake};
  std::shared_ptr<Scene> scene = std::make_shared<Scene>("row", Methods(table), rowOfObjects(300));
  TestClock clock;
  SessionLimits limits = [] {
    SessionLimits l;
    l.max_views = 3;
    l.max_edits_per_request = 4;
    l.max_waiting_edits = 2;
    l.kept_frames = 3;
    l.max_requests_in_flight = 5;
    return l;
  }();
  Session session{scene, limits, "culld/test", Time(0)};
  std::vector<wire::Message> inbox;
  std::vector<SendTag> unsent;
  std::vector<CullJob> culls;
  std::vector<EditJob> edits;
  std::vector<PairsJob> pairs;
  std::optional<Close> closed;
};

}  // namespace culld::server
