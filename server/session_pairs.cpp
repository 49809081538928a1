// The part of Session that answers questions about pairs.
#include <algorithm>
#include <utility>

#include "server/session.h"

namespace culld::server {

using protocol::WireCode;

void Session::handle(std::uint64_t id, protocol::Pairs& m) {
  if (leaving_) return fail(id, WireCode::kUnavailable, "pairs: the server is going away");
  if (full()) return fail(id, WireCode::kLimitExceeded, "pairs: " + fullText());
  if (refusedByQuota(id, "pairs")) return;
  PairsJob job;
  job.request_id = id;
  job.pairs = std::move(m);
  job.received = now_;
  waiting_pairs_.push_back(std::move(job));
  startPairs();
}

/// All that wait, unless the client's own edits come first.
void Session::startPairs() {
  if (editing_ || closed_) return;
  const SceneVersionPtr scene = scene_->current();
  if (!waiting_pairs_.empty() && scene->epoch() != told_epoch_) noticeScene();
  for (PairsJob& job : waiting_pairs_) {
    job.scene = scene;
    running_pairs_.push_back({job.request_id, job.gate});
    ++jobs_;
    actions_.emplace_back(StartPairs{std::move(job)});
  }
  waiting_pairs_.clear();
}

Actions Session::paired(PairsOutcome outcome) {
  --jobs_;
  std::erase_if(running_pairs_, [&outcome](const RunningPairs& running) {
    return running.gate == outcome.job.gate;
  });
  if (closed_ || outcome.message.empty()) return take();  // dropped, and replied to
  if (outcome.job.scene->epoch() != told_epoch_) {
    // The scene was replaced meanwhile: it is asked again of the new one.
    outcome.job.gate = std::make_shared<JobGate>();
    waiting_pairs_.push_back(std::move(outcome.job));
    startPairs();
  } else {
    ++unsent_;
    actions_.emplace_back(Send{std::move(outcome.message), {}, outcome.error});
  }
  return take();
}

void Session::cancelPairs(std::uint64_t request_id) {
  std::size_t cancelled = std::erase_if(
      waiting_pairs_, [&](const PairsJob& job) { return job.request_id == request_id; });
  // One that has begun is not interrupted: its answer comes.
  for (const RunningPairs& running : running_pairs_) {
    if (running.request_id == request_id && running.gate->drop()) ++cancelled;
  }
  for (; cancelled > 0; --cancelled) {
    fail(request_id, WireCode::kCancelled, "pairs: cancelled before the cull began");
  }
}

}  // namespace culld::server
