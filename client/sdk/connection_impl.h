// The inside of Connection and View: who waits for what, under one lock. No sockets, no bytes: see
// link.h and protocol/codec.h for those.
#pragma once
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "client/sdk/backoff.h"
#include "client/sdk/frame_history.h"
#include "client/sdk/link.h"
#include "culld/connection.h"
#include "protocol/messages.h"

namespace culld::client {

/// How an error on the wire is told to a program.
Error errorOf(const protocol::ErrorReply& reply);

struct View::State {
  struct Pending {
    std::uint64_t request = 0;  ///< on the connection of now; 0: an earlier one's, or none yet
    std::uint64_t camera = 0;
    std::uint32_t acknowledged = 0;
    OnAnswer answer;
  };
  ~State();

  std::shared_ptr<Connection::Impl> connection;
  std::uint32_t number = 0;
  std::string asked_method;  ///< as the program named it
  bool want_seen = false;
  // Set before the program gets the view, constant from then on.
  std::string method;
  Guarantee guarantee = Guarantee::kConservative;
  // Guarded by connection->mutex.
  bool given = false;            ///< the program has the view: it is opened again after a loss
  bool open = false;             ///< on the connection of now
  std::optional<Error> refused;  ///< why it could not be opened again
  FrameHistory history;
  FramePtr newest;
  std::uint64_t misfits = 0;
  std::deque<Pending> pending;  ///< ascending by request and camera
  std::optional<protocol::CameraUpdate> last;
  std::uint64_t last_camera = 0;
  std::uint32_t deadline_us = 0;
  std::uint64_t whole_request = 0;  ///< an answer did not fit, and a whole one was asked for; 0: no
  OnFrame callback;
};

struct Connection::Impl : std::enable_shared_from_this<Connection::Impl> {
  using Reply = Result<protocol::Body>;  ///< never an ErrorReply: that is an Error here
  using OnReply = std::function<void(Reply)>;
  using ViewPtr = std::shared_ptr<View::State>;

  Impl(const Address& address, const std::string& scene, const ConnectOptions& options);

  void start(OnOpen callback);
  void close();

  /// Sends `body`; `callback` gets the reply to it, or why there will be none.
  void request(protocol::Body body, OnReply callback);
  /// What a blocking call is refused with on the connection's own thread.
  std::optional<Error> refuseWait() const;

  std::uint64_t setCamera(const ViewPtr& view, const Camera& camera, const Demand& demand,
                          OnAnswer callback);
  void cancel(View::State& view);
  void openView(const ViewPtr& view, OnView callback);
  /// What still waits is told that the view was closed.
  void closeView(View::State& view);

  std::mutex mutex;
  const std::string name;  ///< the address, for messages
  const ConnectOptions options;
  Link link;
  // Guarded by mutex.
  SceneInfo scene;
  ConnectionState state = ConnectionState::kReconnecting;
  std::function<void(const SceneInfo&, bool)> scene_callback;
  std::function<void(ConnectionState, const Error&)> state_callback;
  std::uint32_t next_view = 1;
  std::map<std::uint32_t, std::weak_ptr<View::State>> views;

 private:
  /// What is to be called once the lock is let go.
  using Calls = std::vector<std::function<void()>>;

  void opened();
  void welcomed(Reply reply);
  void reopen(const ViewPtr& view);
  void reopened(const ViewPtr& view, const Reply& reply);
  void received(std::span<const std::uint8_t> bytes);
  void answered(std::uint64_t request, const protocol::Answer& answer, std::size_t wire_bytes);
  void failed(std::uint64_t request, const protocol::ErrorReply& reply);
  void sceneChanged(const protocol::SceneChanged& change);
  std::optional<std::chrono::milliseconds> lost(const Error& error);
  void finished();
  void tellPassedOver();
  void tellState(ConnectionState now, const Error& reason);
  void tellScene(const SceneInfo& now, bool replaced);

  // Under the lock.
  std::uint64_t say(protocol::Body body);
  std::uint64_t askLast(View::State& view, std::uint32_t acknowledged);
  std::vector<ViewPtr> livingViews();
  void giveUp(const Error& why, bool cameras_too, Calls& calls);
  std::optional<std::chrono::milliseconds> nextAttempt(const Error& error);
  static void makeAll(const Calls& calls);

  Backoff backoff_;
  OnOpen opening_;           ///< of the first connection, until it is there or failed
  std::uint64_t hello_ = 0;  ///< the request
  std::uint64_t next_request_ = 1;
  std::map<std::uint64_t, OnReply> waiting_;
  Calls passed_over_;  ///< of cameras, on their way to the link's thread: tellPassedOver()
  std::chrono::steady_clock::time_point connected_since_;
  std::optional<Error> ended_;  ///< why no more answers will come
  std::string going_away_;      ///< the server's reason
};

}  // namespace culld::client
