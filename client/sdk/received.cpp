// What the server says to a Connection::Impl.
#include <algorithm>
#include <iterator>
#include <utility>

#include "client/sdk/connection_impl.h"
#include "protocol/codec.h"
#include "protocol/limits.h"

namespace culld::client {
namespace {

/// Whether the server says so of a camera before it takes the place of an older one.
bool refusedOnArrival(protocol::WireCode code) {
  using protocol::WireCode;
  switch (code) {
    case WireCode::kBadMessage:
    case WireCode::kUnknownView:
    case WireCode::kInvalidCamera:
    case WireCode::kInvalidDemand:
    case WireCode::kLimitExceeded:
    case WireCode::kForbidden:
    case WireCode::kQuotaExceeded:
    case WireCode::kUnavailable:
      return true;
    default:
      return false;
  }
}

}  // namespace

void Connection::Impl::received(std::span<const std::uint8_t> bytes) {
  auto message = protocol::decode(bytes, protocol::kMaxReplyBytes);
  if (!message) {
    if (message.error().code == ErrorCode::kUnsupported) return;  // a word of a newer server
    return link.breakOff(
        {ErrorCode::kUnavailable, name + ": malformed message: " + message.error().message});
  }
  const std::uint64_t id = message.value().id;
  protocol::Body& body = message.value().body;
  if (const auto* answer = std::get_if<protocol::Answer>(&body)) {
    return answered(id, *answer, bytes.size());
  }
  if (const auto* change = std::get_if<protocol::SceneChanged>(&body)) return sceneChanged(*change);
  if (const auto* leaving = std::get_if<protocol::GoAway>(&body)) {
    const std::lock_guard lock(mutex);
    going_away_ = leaving->reason;
    return;
  }
  const auto* refused = std::get_if<protocol::ErrorReply>(&body);
  OnReply callback;
  {
    const std::lock_guard lock(mutex);
    const auto at = waiting_.find(id);
    if (at != waiting_.end()) {
      callback = std::move(at->second);
      waiting_.erase(at);
    }
  }
  if (callback && refused != nullptr) return callback(errorOf(*refused));
  if (callback) return callback(std::move(body));
  if (refused != nullptr && id != 0) failed(id, *refused);
}

void Connection::Impl::answered(std::uint64_t request, const protocol::Answer& answer,
                                std::size_t wire_bytes) {
  ViewPtr view;  // released after the lock: its end takes the lock
  std::vector<OnAnswer> ready;
  OnFrame callback;
  Result<FramePtr> frame = FramePtr();
  {
    const std::lock_guard lock(mutex);
    const auto at = views.find(answer.view);
    if (at != views.end()) view = at->second.lock();
    if (view == nullptr) return;
    std::uint64_t camera = view->last_camera;
    for (const auto& pending : view->pending) {
      if (pending.request == request) camera = pending.camera;
    }
    frame = view->history.apply(answer, camera, wire_bytes);
    if (!frame) {
      if (request < view->whole_request)
        return;  // built on what was forgotten; the whole is coming
      ++view->misfits;
      if (view->last && view->whole_request == 0) {
        view->whole_request = askLast(*view, 0);
        return;
      }
    }
    view->whole_request = 0;
    if (frame) {
      view->newest = frame.value();
      callback = view->callback;
    }
    while (!view->pending.empty() && view->pending.front().request <= request) {
      ready.push_back(std::move(view->pending.front().answer));
      view->pending.pop_front();
    }
    view->history.forgetBefore(view->pending.empty() ? view->history.newestNumber()
                                                     : view->pending.front().acknowledged);
  }
  for (const OnAnswer& waiting : ready) waiting(frame);
  if (callback) callback(frame.value());
}

void Connection::Impl::failed(std::uint64_t request, const protocol::ErrorReply& reply) {
  std::vector<ViewPtr> held;  // released after the lock
  std::vector<OnAnswer> refused;
  {
    const std::lock_guard lock(mutex);
    // Said on the way out: the next connection asks again.
    const bool later = reply.code == protocol::WireCode::kUnavailable && !going_away_.empty() &&
                       options.reconnect.enabled;
    if (later) return;
    held = livingViews();
    for (const ViewPtr& view : held) {
      auto& pending = view->pending;
      const auto at = std::find_if(pending.begin(), pending.end(),
                                   [request](const auto& p) { return p.request == request; });
      if (at == pending.end()) continue;
      // A camera that had passed over older ones takes them along; one that was not let in only
      // those that it was to stand for on a new connection.
      auto first = at;
      while (first != pending.begin() &&
             (!refusedOnArrival(reply.code) || std::prev(first)->request == 0)) {
        --first;
      }
      for (auto it = first; it != at + 1; ++it) refused.push_back(std::move(it->answer));
      pending.erase(first, at + 1);
    }
  }
  for (const OnAnswer& answer : refused) answer(errorOf(reply));
}

void Connection::Impl::sceneChanged(const protocol::SceneChanged& change) {
  std::vector<ViewPtr> held;  // released after the lock
  {
    const std::lock_guard lock(mutex);
    scene = change.scene;
    held = livingViews();
    for (const ViewPtr& view : held) {
      if (change.replaced) view->history.forgetAll();
    }
  }
  tellScene(change.scene, change.replaced);
}

}  // namespace culld::client
