#include "server/pairs_job.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "protocol/codec.h"
#include "protocol/limits.h"
#include "protocol/text.h"
#include "server/translate.h"

namespace culld::server {
namespace {

using protocol::WireCode;

/// More than the most is not spent on one question: a worker that has begun does not stop.
std::chrono::nanoseconds timeOf(const protocol::Pairs& pairs) {
  const std::uint32_t asked = pairs.time_us == 0 ? protocol::kMaxPairsTimeUs : pairs.time_us;
  return std::chrono::microseconds(std::min(asked, protocol::kMaxPairsTimeUs));
}

void refuse(PairsOutcome& outcome, WireCode code, const std::string& what) {
  outcome.error = code;
  outcome.message = protocol::encode(
      {outcome.job.request_id, protocol::ErrorReply{code, protocol::oneLine("pairs: " + what)}});
}

void answerInto(PairsOutcome& outcome, const Clock& clock) {
  const PairsJob& job = outcome.job;
  const auto culler = job.scene->pairs();
  const auto begun = clock.now();
  auto answer = culler->cull(toEngine(job.pairs.viewers), toEngine(job.pairs.targets),
                             timeOf(job.pairs), clock);
  if (!answer) return refuse(outcome, WireCode::kInvalidDemand, answer.error().message);
  PairsAnswer& made = answer.value();
  outcome.pairs = job.pairs.viewers.size() * job.pairs.targets.size();
  outcome.hidden = made.hidden;
  outcome.took = made.time;
  protocol::PairsAnswer out;
  out.scene_version = job.scene->snapshot()->version();
  out.viewers = static_cast<std::uint32_t>(job.pairs.viewers.size());
  out.targets = static_cast<std::uint32_t>(job.pairs.targets.size());
  out.may_see = std::move(made.may_see);
  out.out_of_budget = made.out_of_budget;
  out.cull_ns = static_cast<std::uint64_t>(made.time.count());
  out.queue_ns = static_cast<std::uint64_t>((begun - job.received).count());
  outcome.message = protocol::encode({job.request_id, std::move(out)});
}

}  // namespace

PairsOutcome runPairs(PairsJob job, const Clock& clock) {
  PairsOutcome outcome;
  outcome.job = std::move(job);
  if (!outcome.job.gate->begin()) return outcome;
  try {
    answerInto(outcome, clock);
  } catch (const std::exception& failure) {
    refuse(outcome, WireCode::kInternal, failure.what());
  }
  return outcome;
}

}  // namespace culld::server
