// What a session asks the workers to do. Jobs carry all they need and touch no session, so they run
// on any thread, or in a test's own loop.
#pragma once
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "culling/culler.h"
#include "protocol/id_set.h"
#include "protocol/messages.h"
#include "server/metrics.h"
#include "server/scene.h"

namespace culld::server {

using IdSetPtr = std::shared_ptr<const protocol::IdSet>;

/// What a view keeps between its frames. THREADS: used by one job at a time.
struct ViewMemory {
  ViewState state;
  std::shared_ptr<const Culler> culler;  ///< the one that `state` belongs to
};

/// Settles who came first: the worker that begins a cull, or the session that has given it up.
/// THREADS: any.
class JobGate {
 public:
  bool begin() noexcept { return passTo(State::kBegun); }
  /// False: it has begun, and its outcome will come.
  bool drop() noexcept { return passTo(State::kDropped); }

 private:
  enum class State : std::uint8_t { kQueued, kBegun, kDropped };
  bool passTo(State next) noexcept {
    State queued = State::kQueued;
    return state_.compare_exchange_strong(queued, next);
  }
  std::atomic<State> state_{State::kQueued};
};

struct CullJob {
  std::shared_ptr<JobGate> gate = std::make_shared<JobGate>();
  std::uint64_t request_id = 0;
  std::uint32_t view = 0;
  std::uint64_t incarnation = 0;  ///< tells views apart that were opened under the same number
  std::uint32_t frame = 0;
  std::uint32_t baseline_frame = 0;  ///< 0: none
  IdSetPtr baseline;
  std::uint32_t superseded = 0;
  std::string scene_name;
  SceneVersionPtr scene;
  std::string method;
  bool want_seen = false;
  Camera camera;
  Demand demand;
  std::shared_ptr<ViewMemory> memory;
  std::chrono::nanoseconds received{0};
  std::optional<std::chrono::nanoseconds> deadline;  ///< as Clock::now(); to begin, and to be done
  std::chrono::nanoseconds expected{0};  ///< what this view's last cull took; 0: not known
};

struct CullOutcome {
  CullJob job;
  std::vector<std::uint8_t> message;  ///< encoded: an Answer or an Error; empty: it was dropped
  IdSetPtr visible;                   ///< none: it failed
  protocol::WireCode error = protocol::WireCode::kNone;  ///< the Error's
  std::chrono::nanoseconds took{0};                      ///< culling and encoding
  AnswerReport report;                                   ///< of an Answer
};

struct EditJob {
  std::uint64_t request_id = 0;
  std::uint64_t expected_version = 0;
  std::vector<protocol::EditItem> edits;
};

struct EditDone {
  std::vector<std::uint8_t> message;  ///< encoded: an Edited or an Error
  protocol::WireCode error = protocol::WireCode::kNone;
  bool changed = false;
};

/// Never throws: what a culler throws becomes an Error message. What is left until the deadline
/// bounds the time of the cull, which is cut short as by Demand::time; past it nothing is begun.
CullOutcome runCull(CullJob job, const Clock& clock);
/// One outcome per job, in their order; what the scene keeps of them it keeps in one go.
std::vector<EditDone> runEdits(Scene& scene, std::span<const EditJob> jobs);

}  // namespace culld::server
