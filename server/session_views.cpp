// The half of Session that looks after views: which camera is culled when, which is refused, and
// which frames a client may be told changes of.
#include <algorithm>
#include <utility>

#include "server/session.h"

namespace culld::server {

using protocol::WireCode;

namespace {

constexpr const char* kLate = "the cull could not begin before the deadline";

std::string viewName(std::uint32_t view) { return "view " + std::to_string(view); }

}  // namespace

std::optional<Time> Session::nextTick() const {
  if (closed_) return std::nullopt;
  if (!greeted_) return started_ + limits_.hello_timeout;
  std::optional<Time> next;
  const auto consider = [&next](const std::optional<Time>& deadline) {
    if (deadline && (!next || *deadline < *next)) next = deadline;
  };
  for (const auto& [number, view] : views_) {
    if (view.mailbox) consider(view.mailbox->deadline);
    if (view.running && !view.running->refused && view.running->queued) {
      consider(view.running->deadline);
    }
  }
  return next;
}

void Session::hangUp() {
  for (auto& [number, view] : views_) giveUp(view);
  waiting_pairs_.clear();
  if (running_pairs_) running_pairs_->gate->drop();
  running_pairs_.reset();
}

/// Those who asked for the view's answers have gone.
void Session::giveUp(View& view) {
  view.mailbox.reset();
  if (!view.running) return;
  view.running->gate->drop();
  view.running->refused = true;
}

bool Session::full() const {
  const auto waiting = std::count_if(views_.begin(), views_.end(), [](const auto& entry) {
    return entry.second.mailbox.has_value();
  });
  return jobs_ + static_cast<std::size_t>(waiting) + waiting_edits_.size() + waiting_pairs_.size() +
             (editing_ ? 1U : 0U) >=
         limits_.max_requests_in_flight;
}

std::string Session::fullText() const {
  return "more than " + std::to_string(limits_.max_requests_in_flight) + " requests in flight";
}

void Session::refuseWaiting(std::uint32_t number, View& view, WireCode code, const char* why) {
  fail(view.mailbox->request_id, code, viewName(number) + ": " + why);
  view.mailbox.reset();
}

void Session::refuseRunning(std::uint32_t number, View& view, WireCode code, const char* why) {
  if (std::exchange(view.running->refused, true)) return;
  view.running->gate->drop();
  fail(view.running->request_id, code, viewName(number) + ": " + why);
}

void Session::expire(std::uint32_t number, View& view) {
  if (view.mailbox && view.mailbox->deadline && *view.mailbox->deadline <= now_) {
    refuseWaiting(number, view, WireCode::kDeadlineExceeded, kLate);
  }
  RunningCull* running = view.running ? &*view.running : nullptr;
  if (running == nullptr || running->refused || !running->deadline || *running->deadline > now_) {
    return;
  }
  // One that has begun is cut short by itself, and its outcome comes.
  running->queued = false;
  if (running->gate->drop()) {
    running->refused = true;
    fail(running->request_id, WireCode::kDeadlineExceeded, viewName(number) + ": " + kLate);
  }
}

Session::View* Session::find(std::uint32_t number, std::uint64_t incarnation) {
  const auto at = views_.find(number);
  return at != views_.end() && at->second.incarnation == incarnation ? &at->second : nullptr;
}

void Session::acknowledge(View& view, std::uint32_t frame) {
  const auto at = std::find_if(view.kept.begin(), view.kept.end(),
                               [frame](const KeptFrame& kept) { return kept.frame == frame; });
  view.acked_frame = at == view.kept.end() ? 0 : frame;
  if (at != view.kept.end()) view.kept.erase(view.kept.begin(), at);
}

void Session::keep(View& view, std::uint32_t frame, IdSetPtr visible) {
  view.kept.push_back({frame, std::move(visible)});
  std::size_t ids = 0;
  for (const KeptFrame& kept : view.kept) ids += kept.visible->size();
  while (view.kept.size() > limits_.kept_frames ||
         (view.kept.size() > 1 && ids > limits_.kept_ids)) {
    ids -= view.kept.front().visible->size();
    view.kept.pop_front();
  }
}

void Session::startCull(std::uint32_t number, View& view) {
  // A client's own edits come first, so that its next answer shows them.
  if (view.running || view.unsent || !view.mailbox || editing_ || closed_) return;
  SceneVersionPtr scene = scene_->current();
  if (scene->epoch() != told_epoch_) noticeScene();
  CullJob job;
  job.request_id = view.mailbox->request_id;
  job.view = number;
  job.incarnation = view.incarnation;
  job.frame = ++view.last_frame;
  if (!view.kept.empty() && view.kept.front().frame == view.acked_frame) {
    job.baseline_frame = view.acked_frame;
    job.baseline = view.kept.front().visible;
  }
  job.superseded = std::exchange(view.superseded, 0);
  job.scene_name = scene_->name();
  job.scene = std::move(scene);
  job.method = view.method;
  job.want_seen = view.want_seen;
  job.camera = view.mailbox->camera;
  job.demand = view.mailbox->demand;
  job.memory = view.memory;
  job.received = view.mailbox->received;
  job.deadline = view.mailbox->deadline;
  job.expected = view.last_took;
  view.mailbox.reset();
  view.running = RunningCull{job.request_id, job.deadline, job.gate};
  ++jobs_;
  actions_.emplace_back(StartCull{std::move(job)});
}

void Session::startCulls() {
  for (auto& [number, view] : views_) startCull(number, view);
}

void Session::forgetFrames() {
  for (auto& [number, view] : views_) {
    view.kept.clear();
    view.acked_frame = 0;
    view.last_took = {};  // what the new scene costs is not known
    view.memory = std::make_shared<ViewMemory>();
  }
}

}  // namespace culld::server
