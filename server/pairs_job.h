// A question about pairs, as a session asks it of the workers.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "protocol/messages.h"
#include "server/jobs.h"

namespace culld::server {

struct PairsJob {
  std::shared_ptr<JobGate> gate = std::make_shared<JobGate>();
  std::uint64_t request_id = 0;
  SceneVersionPtr scene;  ///< set when it starts
  protocol::Pairs pairs;
  std::chrono::nanoseconds received{0};
};

struct PairsOutcome {
  PairsJob job;
  std::vector<std::uint8_t> message;  ///< encoded: a PairsAnswer or an Error; empty: it was dropped
  protocol::WireCode error = protocol::WireCode::kNone;  ///< the Error's
  std::size_t pairs = 0, hidden = 0;                     ///< answered, and of these
  std::chrono::nanoseconds took{0};                      ///< the cull, which is paid for
};

/// Never throws: what goes wrong becomes an Error message.
PairsOutcome runPairs(PairsJob job, const Clock& clock);

}  // namespace culld::server
