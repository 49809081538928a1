#include "client/sdk/connection_impl.h"

#include <algorithm>
#include <utility>

#include "protocol/codec.h"
#include "protocol/limits.h"

namespace culld::client {

using protocol::WireCode;

Error errorOf(const protocol::ErrorReply& reply) {
  const auto code = [&reply] {
    switch (reply.code) {
      case WireCode::kUnsupportedVersion:
      case WireCode::kUnsupported:
        return ErrorCode::kUnsupported;
      case WireCode::kUnknownScene:
      case WireCode::kUnknownMethod:
      case WireCode::kUnknownView:
        return ErrorCode::kNotFound;
      case WireCode::kLimitExceeded:
        return ErrorCode::kLimit;
      case WireCode::kConflict:
      case WireCode::kInternal:
      case WireCode::kUnavailable:
        return ErrorCode::kUnavailable;
      default:
        return ErrorCode::kInvalidInput;
    }
  }();
  return {code, reply.message};
}

std::future<Connection::Impl::Reply> Connection::Impl::request(protocol::Body body) {
  const std::lock_guard lock(mutex);
  std::promise<Reply> promise;
  auto future = promise.get_future();
  if (ended) {
    promise.set_value(*ended);
    return future;
  }
  const std::uint64_t id = next_request++;
  socket->send(protocol::encode({id, std::move(body)}));
  waiting.emplace(id, std::move(promise));
  return future;
}

Connection::Impl::Reply Connection::Impl::call(protocol::Body body,
                                               std::chrono::milliseconds limit) {
  auto reply = request(std::move(body));
  if (reply.wait_for(limit) != std::future_status::ready) {
    return Error{ErrorCode::kUnavailable,
                 name + ": no reply within " + std::to_string(limit.count()) + " ms"};
  }
  auto result = reply.get();
  if (!result) return result;
  if (const auto* refused = std::get_if<protocol::ErrorReply>(&result.value())) {
    return errorOf(*refused);
  }
  return result;
}

void Connection::Impl::received(std::span<const std::uint8_t> bytes) {
  auto message = protocol::decode(bytes, protocol::kMaxReplyBytes);
  if (!message) {
    if (message.error().code == ErrorCode::kUnsupported) return;  // a word of a newer server
    return lost({ErrorCode::kUnavailable, "malformed message: " + message.error().message});
  }
  const std::uint64_t id = message.value().id;
  protocol::Body& body = message.value().body;
  if (const auto* answer = std::get_if<protocol::Answer>(&body)) {
    return answered(id, *answer, bytes.size());
  }
  if (const auto* change = std::get_if<protocol::SceneChanged>(&body)) return sceneChanged(*change);
  if (const auto* leaving = std::get_if<protocol::GoAway>(&body)) {
    const std::lock_guard lock(mutex);
    going_away = leaving->reason;
    return;
  }
  std::unique_lock lock(mutex);
  const auto at = waiting.find(id);
  if (at != waiting.end()) {
    std::promise<Reply> promise = std::move(at->second);
    waiting.erase(at);
    lock.unlock();
    promise.set_value(std::move(body));
    return;
  }
  lock.unlock();
  if (const auto* refused = std::get_if<protocol::ErrorReply>(&body)) failed(id, *refused);
}

void Connection::Impl::answered(std::uint64_t request, const protocol::Answer& answer,
                                std::size_t wire_bytes) {
  std::shared_ptr<View::State> view;  // released after the lock: its end takes the lock
  std::vector<std::promise<Result<FramePtr>>> ready;
  std::function<void(const FramePtr&)> callback;
  std::unique_lock lock(mutex);
  const auto at = views.find(answer.view);
  if (at != views.end()) view = at->second.lock();
  if (view == nullptr) return;
  auto frame = view->history.apply(answer, wire_bytes);
  if (!frame && !std::exchange(view->asked_again, true)) return askAgain(*view);
  view->asked_again = false;
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
  lock.unlock();
  for (auto& promise : ready) promise.set_value(frame);
  if (callback) callback(frame.value());
}

/// The newest camera once more, acknowledging nothing: the answer to it stands alone.
void Connection::Impl::askAgain(View::State& view) {
  if (!view.last || ended || socket == nullptr) return;
  view.last->ack_frame = 0;
  const std::uint64_t id = next_request++;
  if (!view.pending.empty()) view.pending.back().request = id;
  socket->send(protocol::encode({id, *view.last}));
}

void Connection::Impl::failed(std::uint64_t request, const protocol::ErrorReply& reply) {
  std::vector<std::shared_ptr<View::State>> held;  // released after the lock
  std::optional<std::promise<Result<FramePtr>>> refused;
  {
    const std::lock_guard lock(mutex);
    for (auto& [number, weak] : views) {
      auto view = weak.lock();
      if (view == nullptr) continue;
      const auto at = std::find_if(view->pending.begin(), view->pending.end(),
                                   [request](const auto& p) { return p.request == request; });
      if (at != view->pending.end()) {
        refused = std::move(at->answer);
        view->pending.erase(at);
      }
      held.push_back(std::move(view));
    }
  }
  if (refused) refused->set_value(errorOf(reply));
}

void Connection::Impl::sceneChanged(const protocol::SceneChanged& change) {
  std::vector<std::shared_ptr<View::State>> held;  // released after the lock
  std::function<void(const SceneInfo&, bool)> callback;
  {
    const std::lock_guard lock(mutex);
    scene = change.scene;
    callback = scene_callback;
    for (auto& [number, weak] : views) {
      auto view = weak.lock();
      if (view == nullptr) continue;
      if (change.replaced) view->history.forgetAll();
      held.push_back(std::move(view));
    }
  }
  if (callback) callback(change.scene, change.replaced);
}

void Connection::Impl::lost(const Error& error) {
  std::vector<std::shared_ptr<View::State>> held;  // released after the lock
  std::vector<std::promise<Result<FramePtr>>> answers;
  std::map<std::uint64_t, std::promise<Reply>> replies;
  Error why{error.code, name + ": " + error.message};
  {
    const std::lock_guard lock(mutex);
    if (ended) return;
    if (!going_away.empty()) why.message = name + ": server went away: " + going_away;
    ended = why;
    replies = std::exchange(waiting, {});
    for (auto& [number, weak] : views) {
      auto view = weak.lock();
      if (view == nullptr) continue;
      for (auto& pending : view->pending) answers.push_back(std::move(pending.answer));
      view->pending.clear();
      held.push_back(std::move(view));
    }
  }
  for (auto& promise : answers) promise.set_value(why);
  for (auto& [id, promise] : replies) promise.set_value(why);
}

}  // namespace culld::client
