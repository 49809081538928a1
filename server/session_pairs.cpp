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

/// The next that waits, unless the client's own edits come first. One at a time: a client holds one
/// worker with them.
void Session::startPairs() {
  if (editing_ || closed_ || running_pairs_ || waiting_pairs_.empty()) return;
  PairsJob job = std::move(waiting_pairs_.front());
  waiting_pairs_.pop_front();
  job.scene = scene_->current();
  if (job.scene->epoch() != told_epoch_) noticeScene();
  running_pairs_ = RunningPairs{job.request_id, job.gate};
  ++jobs_;
  actions_.emplace_back(StartPairs{std::move(job)});
}

Actions Session::paired(PairsOutcome outcome) {
  --jobs_;
  if (!std::exchange(running_pairs_, {}) || closed_) return take();  // or nobody is left
  if (outcome.message.empty()) {
    // Dropped, and replied to.
  } else if (outcome.job.scene->epoch() != told_epoch_) {
    // The scene was replaced meanwhile: it is asked again of the new one.
    outcome.job.gate = std::make_shared<JobGate>();
    waiting_pairs_.push_front(std::move(outcome.job));
  } else {
    ++unsent_;
    actions_.emplace_back(Send{std::move(outcome.message), {}, outcome.error});
  }
  startPairs();
  return take();
}

void Session::cancelPairs(std::uint64_t request_id) {
  std::size_t cancelled = std::erase_if(
      waiting_pairs_, [&](const PairsJob& job) { return job.request_id == request_id; });
  // One that has begun is not interrupted: its answer comes.
  if (running_pairs_ && running_pairs_->request_id == request_id && running_pairs_->gate->drop()) {
    ++cancelled;
  }
  for (; cancelled > 0; --cancelled) {
    fail(request_id, WireCode::kCancelled, "pairs: cancelled before the cull began");
  }
}

}  // namespace culld::server
