// A live connection to one scene of a culld server, and views on it whose visible sets it keeps up
// to date. Network and threads stay inside: these headers need the standard library only.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <string>
#include <vector>

#include "culld/address.h"
#include "protocol/messages.h"
#include "protocol/result.h"

namespace culld::client {

using protocol::Camera;
using protocol::Demand;
using protocol::Done;
using protocol::EditItem;
using protocol::Error;
using protocol::ErrorCode;
using protocol::Guarantee;
using protocol::Result;
using protocol::SceneInfo;

/// One answer, with the whole visible set even where only changes came over the wire. Immutable.
struct Frame {
  std::uint32_t number = 0;            ///< of this view, ascending
  std::vector<std::uint32_t> visible;  ///< object ids, ascending, unique
  std::vector<std::uint8_t> seen;      ///< per visible object 1: certainly visible; may be empty
  std::uint32_t seen_count = 0;        ///< of `visible`: certainly visible
  std::uint32_t kept_count = 0;        ///< kept for safety; both counts 0: the method does not tell
  std::uint64_t scene_version = 0;
  std::uint32_t scene_objects = 0;
  Guarantee guarantee = Guarantee::kConservative;
  float missed_px = 0.0F;
  bool proven = true;
  bool out_of_budget = false;
  std::string method, note;
  std::string made_by;           ///< the method that made it, where `method` has a choice
  std::uint32_t superseded = 0;  ///< older cameras that the server passed over
  protocol::Stats stats;
  std::size_t wire_bytes = 0;  ///< size of the message that brought it
  bool delta = false;          ///< it came as a change of an earlier frame
};
using FramePtr = std::shared_ptr<const Frame>;

struct Timeouts {
  std::chrono::milliseconds connect{5'000};  ///< TCP, WebSocket and version handshake, each
  std::chrono::milliseconds reply{30'000};   ///< for blocking calls
  std::chrono::milliseconds idle{60'000};    ///< silence, pings unanswered: the connection is lost
};

/// A stream of cameras and answers. Cheap to copy; the last copy closes the view.
/// THREADS: any.
class View {
 public:
  /// Sends a camera; the newest wins. The future holds the answer to this camera, or to a newer one
  /// of this view if the server passed over this one. COST: returns at once.
  std::future<Result<FramePtr>> setCamera(const Camera& camera, const Demand& demand = {});

  /// setCamera() and wait. ERROR: kUnavailable: no answer in time, or connection lost;
  /// kInvalidInput: what the server says about camera or demand.
  Result<FramePtr> cull(const Camera& camera, const Demand& demand = {});

  /// Called for every answer, on the connection's thread; it may call setCamera() but must not
  /// wait.
  void onFrame(std::function<void(const FramePtr&)> callback);

  FramePtr newest() const;  ///< null before the first answer
  const std::string& method() const;
  Guarantee guarantee() const;  ///< what the method promises at least

 private:
  friend class Connection;
  struct State;
  explicit View(std::shared_ptr<State> state);
  std::shared_ptr<State> state_;
};

struct EditOutcome {
  std::uint64_t scene_version = 0;
  std::vector<std::uint32_t> added;  ///< ids of the added objects, in order
};

/// THREADS: any. Destroying it closes the connection; its views then answer with errors.
class Connection {
 public:
  /// ERROR: kUnavailable: nobody there; kNotFound: no such scene; kUnsupported: no common version.
  static Result<std::unique_ptr<Connection>> open(const Address& address, const std::string& scene,
                                                  const Timeouts& timeouts = {});
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// `method` empty: the server chooses. ERROR: kNotFound: unknown method; kLimit: too many views.
  Result<View> openView(const std::string& method = {}, bool want_seen = false);

  /// All or none. `expected_version` 0: any. ERROR: kInvalidInput naming the edit; kUnavailable:
  /// the scene is at another version.
  Result<EditOutcome> edit(std::vector<EditItem> edits, std::uint64_t expected_version = 0);

  /// There and back through the message layer.
  Result<std::chrono::nanoseconds> ping();

  SceneInfo scene() const;  ///< as last told by the server
  /// Called, on the connection's thread, when the scene was edited or replaced.
  void onSceneChanged(std::function<void(const SceneInfo&, bool replaced)> callback);

  struct Impl;  ///< the inside, shared with the views

 private:
  explicit Connection(std::shared_ptr<Impl> impl);
  std::shared_ptr<Impl> impl_;
};

}  // namespace culld::client
