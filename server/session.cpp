#include "server/session.h"

#include <algorithm>
#include <utility>

#include "protocol/codec.h"
#include "protocol/text.h"
#include "protocol/version.h"
#include "server/scene_names.h"
#include "server/translate.h"

namespace culld::server {

using protocol::Message;
using protocol::WireCode;

namespace {

constexpr std::uint16_t kClosePolicy = 1008;

std::string viewName(std::uint32_t view) { return "view " + std::to_string(view); }

WireCode decodeCode(protocol::ErrorCode code) {
  if (code == protocol::ErrorCode::kLimit) return WireCode::kLimitExceeded;
  if (code == protocol::ErrorCode::kUnsupported) return WireCode::kUnsupported;
  return WireCode::kBadMessage;
}

}  // namespace

Session::Session(std::shared_ptr<Scene> scene, const SessionLimits& limits, std::string server_name,
                 Time now, SessionRights rights)
    : scene_(std::move(scene)),
      limits_(limits),
      server_name_(std::move(server_name)),
      rights_(std::move(rights)),
      started_(now),
      now_(now) {}

// --- what comes in -------------------------------------------------------------------------------

Actions Session::receive(std::span<const std::uint8_t> bytes, Time now) {
  now_ = now;
  if (closed_) return {};
  std::uint64_t id = 0;
  auto message = protocol::decode(bytes, limits_.max_message_bytes, &id);
  if (message) {
    dispatch(message.value());
  } else {
    fail(id, decodeCode(message.error().code), message.error().message);
  }
  return take();
}

Actions Session::receiveText() {
  if (!closed_) fail(0, WireCode::kBadMessage, "text frame where a binary message is due");
  return take();
}

void Session::dispatch(Message& message) {
  const std::uint64_t id = message.id;
  if (!greeted_ && !std::holds_alternative<protocol::Hello>(message.body)) {
    return fail(id, WireCode::kHelloExpected, "the first message must be Hello");
  }
  std::visit(
      [this, id](auto& body) {
        if constexpr (requires { handle(id, body); }) {
          handle(id, body);
        } else {
          fail(id, WireCode::kBadMessage, "a message that only a server sends");
        }
      },
      message.body);
}

void Session::handle(std::uint64_t id, const protocol::Hello& m) {
  if (greeted_) return fail(id, WireCode::kBadMessage, "Hello was said already");
  if (m.proto_min > protocol::kProtocolMax || m.proto_max < protocol::kProtocolMin ||
      m.proto_min > m.proto_max) {
    return fail(id, WireCode::kUnsupportedVersion,
                "protocol " + std::to_string(m.proto_min) + " to " + std::to_string(m.proto_max) +
                    " asked for, " + std::to_string(protocol::kProtocolMin) + " to " +
                    std::to_string(protocol::kProtocolMax) + " spoken here");
  }
  greeted_ = true;
  const SceneVersionPtr scene = scene_->current();
  protocol::Welcome welcome;
  welcome.protocol = std::min(m.proto_max, protocol::kProtocolMax);
  welcome.server = server_name_;
  welcome.limits = {static_cast<std::uint32_t>(limits_.max_message_bytes), limits_.max_views,
                    limits_.max_edits_per_request,
                    static_cast<std::uint32_t>(limits_.idle_timeout.count())};
  welcome.scene = describe(std::string(publicName(scene_->name())), *scene->snapshot());
  welcome.limits.max_requests_in_flight = limits_.max_requests_in_flight;
  welcome.limits.max_waiting_edits = limits_.max_waiting_edits;
  welcome.limits.max_messages_per_s = limits_.max_messages_per_s;
  welcome.limits.max_text_bytes = static_cast<std::uint32_t>(protocol::kMaxTextBytes);
  welcome.limits.max_image_side_px = protocol::kMaxImageSide;
  welcome.limits.kept_frames = static_cast<std::uint32_t>(limits_.kept_frames);
  welcome.features =
      protocol::kFeatureCancel | protocol::kFeatureDeadlines | protocol::kFeaturePairs;
  told_epoch_ = scene->epoch();
  told_version_ = welcome.scene.version;
  reply(id, std::move(welcome));
}

void Session::handle(std::uint64_t id, const protocol::OpenView& m) {
  const auto method = scene_->current()->method(m.method);
  if (!method) {
    return fail(id, toWire(method.error().code, WireCode::kUnknownMethod),
                viewName(m.view) + ": " + method.error().message);
  }
  if (!views_.contains(m.view) && views_.size() >= limits_.max_views) {
    return fail(id, WireCode::kLimitExceeded,
                viewName(m.view) + ": more than " + std::to_string(limits_.max_views) + " views");
  }
  if (const auto old = views_.find(m.view); old != views_.end()) giveUp(old->second);
  View view;
  view.incarnation = next_incarnation_++;
  view.method = m.method;
  view.want_seen = m.want_seen;
  views_.insert_or_assign(m.view, std::move(view));
  const MethodInfo info = method.value()->info();
  reply(id, protocol::ViewOpened{m.view, std::string(info.name), toWire(info.guarantee)});
}

void Session::handle(std::uint64_t id, const protocol::CloseView& m) {
  const auto at = views_.find(m.view);
  if (at == views_.end()) {
    return fail(id, WireCode::kUnknownView, viewName(m.view) + " is not open");
  }
  giveUp(at->second);
  views_.erase(at);
  reply(id, protocol::ViewClosed{m.view});
}

void Session::handle(std::uint64_t id, const protocol::CameraUpdate& m) {
  const auto at = views_.find(m.view);
  if (at == views_.end()) {
    return fail(id, WireCode::kUnknownView, viewName(m.view) + " is not open");
  }
  if (leaving_) {
    return fail(id, WireCode::kUnavailable, viewName(m.view) + ": the server is going away");
  }
  const auto camera = toEngine(m.camera);
  if (!camera) {
    return fail(id, WireCode::kInvalidCamera, viewName(m.view) + ": " + camera.error().message);
  }
  const auto demand = toEngine(m.demand);
  if (!demand) {
    return fail(id, WireCode::kInvalidDemand, viewName(m.view) + ": " + demand.error().message);
  }
  View& view = at->second;
  if (!view.mailbox && full()) {
    return fail(id, WireCode::kLimitExceeded, viewName(m.view) + ": " + fullText());
  }
  acknowledge(view, m.ack_frame);
  if (refusedByQuota(id, viewName(m.view))) return;
  if (view.mailbox) ++view.superseded;
  view.mailbox = WaitingCamera{id, camera.value(), demand.value(), now_, {}};
  if (m.deadline_us != 0) view.mailbox->deadline = now_ + std::chrono::microseconds(m.deadline_us);
  startCull(m.view, view);
}

bool Session::refusedByQuota(std::uint64_t id, const std::string& what) {
  const auto spent = rights_.tenant ? rights_.tenant->refuseCull(now_) : std::nullopt;
  if (!spent) return false;
  fail(id, WireCode::kQuotaExceeded, what + ": " + spent->message);
  std::get_if<Send>(&actions_.back())->quota = spent->reason;
  return true;
}

void Session::handle(std::uint64_t id, protocol::Edit& m) {
  if (!rights_.edit_refusal.empty()) {
    return fail(id, WireCode::kForbidden, "edit: " + rights_.edit_refusal);
  }
  if (leaving_) return fail(id, WireCode::kUnavailable, "edit: the server is going away");
  if (m.edits.empty()) return fail(id, WireCode::kInvalidEdit, "edit: an empty list");
  if (m.edits.size() > limits_.max_edits_per_request) {
    return fail(id, WireCode::kLimitExceeded,
                "edit: " + std::to_string(m.edits.size()) + " edits > " +
                    std::to_string(limits_.max_edits_per_request));
  }
  if (waiting_edits_.size() >= limits_.max_waiting_edits) {
    return fail(id, WireCode::kLimitExceeded,
                "edit: " + std::to_string(waiting_edits_.size()) + " are waiting already");
  }
  if (full()) return fail(id, WireCode::kLimitExceeded, "edit: " + fullText());
  waiting_edits_.push_back({id, m.expected_version, std::move(m.edits)});
  startEdit();
}

void Session::handle(std::uint64_t id, const protocol::Ping& m) {
  reply(id, protocol::Pong{m.time_ns});
}

/// Whoever is named gets one reply: Cancelled from here, or the usual one where it is too late. So
/// Cancel itself has none.
void Session::handle(std::uint64_t, const protocol::Cancel& m) {
  for (auto& [number, view] : views_) {
    if (view.mailbox && view.mailbox->request_id == m.request_id) {
      refuseWaiting(number, view, WireCode::kCancelled, "cancelled while it waited");
    }
    if (view.running && view.running->request_id == m.request_id) {
      refuseRunning(number, view, WireCode::kCancelled, "cancelled while it was culled");
    }
  }
  const auto cancelled = std::erase_if(
      waiting_edits_, [&m](const EditJob& edit) { return edit.request_id == m.request_id; });
  if (cancelled != 0) {
    fail(m.request_id, WireCode::kCancelled, "edit: cancelled before it was applied");
  }
  cancelPairs(m.request_id);
}

// --- work done -----------------------------------------------------------------------------------

Actions Session::culled(CullOutcome outcome) {
  --jobs_;
  CullJob& job = outcome.job;
  View* view = find(job.view, job.incarnation);
  if (view == nullptr || closed_) return take();
  const bool refused = std::exchange(view->running, {})->refused;
  // One cheap cull does not make the next one cheap: an expensive one is forgotten slowly.
  view->last_took = std::max(outcome.took, view->last_took - view->last_took / 16);
  if (refused) {
    view->superseded += job.superseded;
  } else if (job.scene->epoch() != told_epoch_) {
    // The scene was replaced meanwhile. Its newest camera still wants an answer.
    view->superseded += job.superseded + (view->mailbox ? 1U : 0U);
    if (!view->mailbox) {
      view->mailbox =
          WaitingCamera{job.request_id, job.camera, job.demand, job.received, job.deadline};
    }
  } else if (outcome.visible) {
    keep(*view, job.frame, std::move(outcome.visible));
    view->unsent = true;
    ++unsent_;
    actions_.push_back(
        Send{std::move(outcome.message), {SendTag::Kind::kAnswer, job.view, job.incarnation}, {}});
  } else {
    view->superseded += job.superseded;
    ++unsent_;
    actions_.emplace_back(Send{std::move(outcome.message), {}, outcome.error});
  }
  startCull(job.view, *view);
  return take();
}

Actions Session::edited(EditDone done) {
  editing_ = false;
  if (closed_) return {};
  ++unsent_;
  actions_.emplace_back(Send{std::move(done.message), {}, done.error});
  startEdit();
  startCulls();
  startPairs();
  return take();
}

Actions Session::sent(const SendTag& tag) {
  --unsent_;
  if (closed_) return {};
  if (tag.kind == SendTag::Kind::kNotice) {
    notice_unsent_ = false;
    noticeScene();
  }
  if (tag.kind == SendTag::Kind::kAnswer) {
    if (View* view = find(tag.view, tag.incarnation)) {
      view->unsent = false;
      startCull(tag.view, *view);
    }
  }
  return take();
}

Actions Session::sceneMoved() {
  if (greeted_ && !closed_) noticeScene();
  return take();
}

Actions Session::tick(Time now) {
  now_ = now;
  if (!greeted_ && !closed_ && now - started_ >= limits_.hello_timeout) {
    closed_ = true;
    actions_.emplace_back(Close{kClosePolicy, "no Hello in time"});
  }
  if (!closed_) {
    for (auto& [number, view] : views_) expire(number, view);
  }
  return take();
}

Actions Session::goAway(const std::string& reason) {
  if (!leaving_ && !closed_) {
    leaving_ = true;
    reply(0, protocol::GoAway{reason});
  }
  return take();
}

bool Session::drained() const noexcept {
  const bool waiting = std::any_of(views_.begin(), views_.end(), [](const auto& entry) {
    return entry.second.mailbox.has_value();
  });
  return jobs_ == 0 && unsent_ == 0 && !editing_ && waiting_edits_.empty() &&
         waiting_pairs_.empty() && !waiting;
}

// --- inner workings ------------------------------------------------------------------------------

void Session::reply(std::uint64_t id, protocol::Body body) {
  ++unsent_;
  actions_.emplace_back(Send{protocol::encode(Message{id, std::move(body)}), {}, {}});
}

void Session::fail(std::uint64_t id, WireCode code, const std::string& message) {
  ++unsent_;
  const protocol::ErrorReply refusal{code, protocol::oneLine(message)};
  actions_.emplace_back(Send{protocol::encode(Message{id, refusal}), {}, code});
}

void Session::startEdit() {
  if (editing_ || waiting_edits_.empty()) return;
  editing_ = true;
  actions_.emplace_back(StartEdit{std::move(waiting_edits_.front())});
  waiting_edits_.pop_front();
}

void Session::noticeScene() {
  const SceneVersionPtr scene = scene_->current();
  const bool replaced = scene->epoch() != told_epoch_;
  const std::uint64_t version = scene->snapshot()->version();
  if (!replaced && (version == told_version_ || notice_unsent_)) return;
  if (replaced) forgetFrames();
  told_epoch_ = scene->epoch();
  told_version_ = version;
  notice_unsent_ = true;
  ++unsent_;
  actions_.push_back(Send{
      protocol::encode(Message{
          0,
          protocol::SceneChanged{
              describe(std::string(publicName(scene_->name())), *scene->snapshot()), replaced}}),
      {SendTag::Kind::kNotice, 0, 0},
      {}});
}
}  // namespace culld::server
