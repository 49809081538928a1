// A live connection to one scene of a culld server, and views on it whose visible sets it keeps up
// to date. Network and threads stay inside: these headers need the standard library only.
//
// THREADS: every function may be called on any thread. A connection has a thread of its own, and
// all callbacks are called on it, one at a time, with no lock held: they may call whatever does not
// wait, close the connection and even destroy it. What waits for that thread (openView, cull, edit,
// pairs, ping without a callback) refuses at once to be called there. Callbacks must not throw.
// What is refused without asking the server, as after the end, calls back before the call returns.
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
#include "culld/options.h"
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
using protocol::Place;
using protocol::Result;
using protocol::SceneInfo;

/// One answer, with the whole visible set even where only changes came over the wire. Immutable.
struct Frame {
  std::uint32_t number = 0;            ///< of this view, ascending; from 1 again after a reconnect
  std::uint64_t camera = 0;            ///< the setCamera() that it answers
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

using OnFrame = std::function<void(const FramePtr&)>;
using OnAnswer = std::function<void(const Result<FramePtr>&)>;

/// A stream of cameras and answers. Cheap to copy; the last copy closes the view.
class View {
 public:
  /// Sends a camera; the newest wins. The future holds the answer to this camera, or to a newer one
  /// of this view if the server passed over this one. A camera that is under way when the
  /// connection is lost is sent again on the next one. COST: returns at once.
  std::future<Result<FramePtr>> setCamera(const Camera& camera, const Demand& demand = {});
  /// The same with a callback; returns the camera's number: 1 for the first of the view, and so on.
  std::uint64_t setCamera(const Camera& camera, const Demand& demand, OnAnswer callback);

  /// setCamera() and wait. ERROR: kUnavailable: no answer in time, or connection lost;
  /// kInvalidInput: what the server says about camera or demand.
  Result<FramePtr> cull(const Camera& camera, const Demand& demand = {});

  /// Cameras from now on are worth nothing if their cull has not begun so long after they reached
  /// the server: they end with kDeadline. 0: no deadline. Servers too old for this ignore it.
  void setDeadline(std::chrono::microseconds deadline);
  /// Takes back what waits: it ends with kCancelled, unless an answer is on its way already.
  /// COST: returns at once.
  void cancel();

  /// Called for every answer.
  void onFrame(OnFrame callback);

  FramePtr newest() const;  ///< null before the first answer
  /// How many answers did not fit their own count and hash and were asked again.
  std::uint64_t misfits() const;
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

/// Which viewers may see which targets.
struct PairsOutcome {
  std::uint64_t scene_version = 0;
  std::size_t viewers = 0, targets = 0;
  std::vector<std::uint8_t> bits;  ///< bit viewer * targets + target, lowest of each byte first
  bool out_of_budget = false;      ///< time ran out: pairs not looked at are kept
  std::chrono::nanoseconds cull{0}, queued{0};

  /// False: proven hidden. REQUIRES: viewer < viewers, target < targets.
  bool maySee(std::size_t viewer, std::size_t target) const {
    const std::size_t bit = viewer * targets + target;
    return (static_cast<unsigned>(bits[bit / 8]) >> bit % 8 & 1U) != 0;
  }
};

enum class ConnectionState : std::uint8_t {
  kConnected,
  kReconnecting,  ///< lost; cameras wait, other requests fail until it is connected again
  kEnded,         ///< for good
};

/// When a connection is lost it is made again (ConnectOptions::reconnect): views are opened again
/// under their numbers, and the last camera of each is asked again, so that its visible set starts
/// from a whole answer. What was under way besides cameras fails: whether an edit was carried out
/// is then not known. Views of a connection that has ended answer with errors.
class Connection {
 public:
  /// One attempt. ERROR: kUnavailable: nobody there; kNotFound: no such scene; kUnsupported: no
  /// common version; kInvalidInput: token or ca_file.
  static Result<std::unique_ptr<Connection>> open(const Address& address, const std::string& scene,
                                                  const ConnectOptions& options = {});
  using OnOpen = std::function<void(Result<std::unique_ptr<Connection>>)>;
  static void open(const Address& address, const std::string& scene, const ConnectOptions& options,
                   OnOpen callback);

  /// close(); then waits until all callbacks have returned but the one that it is called in.
  ~Connection();
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  /// Ends every wait, on whatever thread, with an error. COST: returns at once.
  void close();

  /// `method` empty: the server chooses. ERROR: kNotFound: unknown method; kLimit: too many views.
  Result<View> openView(const std::string& method = {}, bool want_seen = false);
  using OnView = std::function<void(Result<View>)>;
  void openView(const std::string& method, bool want_seen, OnView callback);

  /// All or none. `expected_version` 0: any. ERROR: kInvalidInput naming the edit; kUnavailable:
  /// the scene is at another version.
  Result<EditOutcome> edit(std::vector<EditItem> edits, std::uint64_t expected_version = 0);
  using OnEdited = std::function<void(Result<EditOutcome>)>;
  void edit(std::vector<EditItem> edits, std::uint64_t expected_version, OnEdited callback);

  /// Which of `viewers` may see which of `targets`? Objects of the scene hide; the places
  /// themselves do not. `time` 0: what the server allows, two seconds. ERROR: kInvalidInput naming
  /// the place; kLimit: more than protocol::kMaxPairs pairs, or more places than a message holds,
  /// some 4,600; kUnsupported: a server that is too old.
  Result<PairsOutcome> pairs(std::vector<Place> viewers, std::vector<Place> targets,
                             std::chrono::microseconds time = {});
  using OnPairs = std::function<void(Result<PairsOutcome>)>;
  void pairs(std::vector<Place> viewers, std::vector<Place> targets, std::chrono::microseconds time,
             OnPairs callback);

  /// There and back through the message layer.
  Result<std::chrono::nanoseconds> ping();
  using OnPong = std::function<void(Result<std::chrono::nanoseconds>)>;
  void ping(OnPong callback);

  SceneInfo scene() const;  ///< as last told by the server
  /// Called when the scene was edited or replaced, also while the connection was lost.
  void onSceneChanged(std::function<void(const SceneInfo&, bool replaced)> callback);

  ConnectionState state() const;
  /// Called when the state changes, with the reason (empty for kConnected), but not by close().
  void onState(std::function<void(ConnectionState, const Error& reason)> callback);

  struct Impl;  ///< the inside, shared with the views

 private:
  explicit Connection(std::shared_ptr<Impl> impl);
  std::shared_ptr<Impl> impl_;
};

}  // namespace culld::client
