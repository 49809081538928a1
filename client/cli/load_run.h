// Many clients that send cameras by the clock, whatever becomes of the answers: an open loop. Each
// camera has its time in a schedule made beforehand, and its latency counts from there; so a server
// that stalls is charged for every camera that was due meanwhile (no coordinated omission).
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "client/cli/commands.h"
#include "client/cli/histogram.h"
#include "client/cli/load_check.h"
#include "client/cli/motion.h"
#include "culld/connection.h"

namespace culld::client {

struct LoadResult {
  std::uint64_t due = 0;     ///< times in the schedule, over all views
  std::uint64_t within = 0;  ///< of these: the last answer still held there, so none was sent
  std::uint64_t sent = 0;    ///< with `within` less than `due` if every connection was lost
  std::uint64_t answered = 0;
  std::uint64_t superseded = 0;  ///< cameras whose answer was that to a newer one
  std::uint64_t late = 0;        ///< of the answered: later than allowed
  std::uint64_t failed = 0;
  std::uint64_t unanswered = 0;
  std::uint64_t wrong = 0;     ///< sets that are not what they were said to be
  std::uint64_t compared = 0;  ///< with the whole answer to the same camera
  std::uint64_t bytes = 0, deltas = 0, cull_ns = 0, queue_ns = 0;
  Histogram latency_ns;  ///< of the answered
  std::string first_error;
  std::string method;
  double seconds = 0.0;
};

class LoadRun {
 public:
  /// Connects all clients and opens their views. Returns kFine, or the exit code after it has said
  /// what is wrong. REQUIRES: `arguments` and `server` outlive this.
  int start(const Server& server, const LoadArguments& arguments);
  LoadResult run();

 private:
  using Clock = std::chrono::steady_clock;

  /// What one client counted, on its connection's thread alone.
  struct Counts {
    std::uint64_t answered = 0, superseded = 0, late = 0, failed = 0, unanswered = 0;
    std::uint64_t bytes = 0, deltas = 0, cull_ns = 0, queue_ns = 0;
    Histogram latency_ns;
    std::string first_error;
  };
  struct Slot {  ///< one view
    View view;
    Counts* counts = nullptr;
    std::size_t phase = 0;    ///< where on the path it begins
    std::uint64_t asked = 0;  ///< cameras so far
    Pose asked_at;
    Clock::time_point due;
  };

  void ask(Slot& slot, std::uint64_t tick);
  void answered(Counts& counts, std::uint64_t camera, std::size_t index, Clock::time_point due,
                const Result<FramePtr>& frame);
  bool anyConnected() const;
  void awaitRest() const;

  const LoadArguments* arguments_ = nullptr;
  std::vector<Camera> cameras_;
  std::vector<Pose> poses_;
  Demand demand_;
  Clock::duration allowed_{};
  std::unique_ptr<LoadCheck> check_;
  std::vector<std::unique_ptr<Counts>> counts_;
  std::vector<Slot> slots_;
  std::atomic<std::uint64_t> told_ = 0;  ///< cameras of which the end is known
  std::atomic<bool> ending_ = false;
  std::uint64_t within_ = 0, sent_ = 0;
  /// Last: their callbacks use what is above.
  std::vector<std::unique_ptr<Connection>> connections_;
};

}  // namespace culld::client
