// What the connections of a server share.
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <set>
#include <string>

#include "culling/core/clock.h"
#include "server/access.h"
#include "server/address_counts.h"
#include "server/edit_queue.h"
#include "server/limits.h"
#include "server/log.h"
#include "server/metrics.h"
#include "server/scene_store.h"
#include "server/tls.h"
#include "server/worker_pool.h"

namespace culld::server {

/// A live connection as the rest of the server sees it. THREADS: the I/O thread.
class LivePeer {
 public:
  virtual ~LivePeer() = default;
  virtual const std::shared_ptr<Scene>& scene() const = 0;
  virtual std::size_t viewCount() const = 0;
  virtual bool stillWelcome() const = 0;
  virtual void sceneMoved() = 0;
  /// Says GoAway, finishes what runs, closes with 1001.
  virtual void goAway(const std::string& reason) = 0;
};

struct Context {
  ServerLimits limits;  ///< THREADS: the I/O thread
  const std::string server_name;
  const Clock& clock;
  SceneStore& store;
  Metrics& metrics;
  Log& log;
  Access& access;
  const TlsKeys* tls;   ///< of the TCP port; none: it is plain
  WorkerPool& workers;  ///< culling
  WorkerPool& loaders;  ///< uploads: slow, so they do not keep cameras waiting
  EditQueue& edits;
  /// Runs on the I/O thread, soon. THREADS: any.
  std::function<void(std::function<void()>)> onIoThread;
  const std::chrono::nanoseconds started;

  // THREADS: the I/O thread, but for the atomics.
  std::set<LivePeer*> live;
  std::size_t busy_requests = 0;     ///< HTTP requests under way
  std::uint64_t sessions_begun = 0;  ///< live ones, since the start; numbers them in the log
  std::size_t queued_bytes = 0;      ///< messages of all sessions that wait to be sent
  AddressCounts addresses{};
  std::atomic<bool> ready{false};
  std::atomic<bool> draining{false};

  void sceneMoved(const Scene* scene) {
    for (LivePeer* peer : std::set<LivePeer*>(live)) {
      if (live.contains(peer) && peer->scene().get() == scene) peer->sceneMoved();
    }
  }
  /// After a reload: ends the sessions of tokens that were withdrawn. A ticket lives for seconds,
  /// so all go: whoever holds one of an old token comes again with a new one.
  void accessChanged() {
    access.tickets().clear();
    for (LivePeer* peer : std::set<LivePeer*>(live)) {
      if (live.contains(peer) && !peer->stillWelcome()) peer->goAway("the token was withdrawn");
    }
  }
  void goAway(const Scene* scene, const std::string& reason) {
    for (LivePeer* peer : std::set<LivePeer*>(live)) {
      const bool meant = scene == nullptr || peer->scene().get() == scene;
      if (live.contains(peer) && meant) peer->goAway(reason);
    }
  }
};

}  // namespace culld::server
