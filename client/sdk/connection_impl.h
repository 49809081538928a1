// The inside of Connection and View: who waits for what, under one lock. No Beast, no bytes: see
// live_socket.h and protocol/codec.h for those.
#pragma once
#include <cstdint>
#include <deque>
#include <future>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>

#include "client/sdk/frame_history.h"
#include "client/sdk/live_socket.h"
#include "culld/connection.h"
#include "protocol/messages.h"

namespace culld::client {

/// How an error on the wire is told to a program.
Error errorOf(const protocol::ErrorReply& reply);

struct View::State {
  struct Pending {
    std::uint64_t request = 0;
    std::uint32_t acknowledged = 0;
    std::promise<Result<FramePtr>> answer;
  };
  ~State();

  std::shared_ptr<Connection::Impl> connection;
  std::uint32_t number = 0;
  std::string method;
  Guarantee guarantee = Guarantee::kConservative;
  // Guarded by connection->mutex.
  FrameHistory history;
  FramePtr newest;
  std::deque<Pending> pending;  ///< ascending by request
  std::optional<protocol::CameraUpdate> last;
  bool asked_again = false;  ///< the last answer did not fit, a whole one is under way
  std::function<void(const FramePtr&)> callback;
};

struct Connection::Impl {
  using Reply = Result<protocol::Body>;

  /// Sends `body` and returns what will hold the reply to it.
  std::future<Reply> request(protocol::Body body);
  /// Waits for it. ERROR: kUnavailable after `limit`; what an ErrorReply says.
  Reply call(protocol::Body body, std::chrono::milliseconds limit);

  void received(std::span<const std::uint8_t> bytes);
  void lost(const Error& error);

  std::mutex mutex;
  std::string name;  ///< address and scene, for messages
  Timeouts timeouts;
  std::unique_ptr<LiveSocket> socket;  ///< gone once the Connection is destroyed
  std::uint64_t next_request = 1;
  std::uint32_t next_view = 1;
  std::map<std::uint64_t, std::promise<Reply>> waiting;
  std::map<std::uint32_t, std::weak_ptr<View::State>> views;
  SceneInfo scene;
  std::function<void(const SceneInfo&, bool)> scene_callback;
  std::optional<Error> ended;  ///< why no more answers will come
  std::string going_away;      ///< the server's reason

 private:
  void answered(std::uint64_t request, const protocol::Answer& answer, std::size_t wire_bytes);
  void failed(std::uint64_t request, const protocol::ErrorReply& reply);
  void sceneChanged(const protocol::SceneChanged& change);
  void askAgain(View::State& view);
};

}  // namespace culld::client
