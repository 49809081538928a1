#include "client/sdk/connection_impl.h"

#include <algorithm>
#include <random>
#include <utility>

#include "client/sdk/dial.h"
#include "protocol/codec.h"
#include "protocol/limits.h"
#include "protocol/version.h"

namespace culld::client {

using protocol::WireCode;
using std::chrono::milliseconds;

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
      case WireCode::kQuotaExceeded:
        return ErrorCode::kUnavailable;
      case WireCode::kForbidden:
        return ErrorCode::kForbidden;
      case WireCode::kCancelled:
        return ErrorCode::kCancelled;
      case WireCode::kDeadlineExceeded:
        return ErrorCode::kDeadline;
      default:
        return ErrorCode::kInvalidInput;
    }
  }();
  return {code, reply.message};
}

Connection::Impl::Impl(const Address& address, const std::string& scene_name,
                       const ConnectOptions& how)
    : name(toString(address)),
      options(how),
      link(address, "/v1/scenes/" + percentEncoded(scene_name) + "/live", how),
      backoff_(how.reconnect, std::random_device{}()) {}

void Connection::Impl::start(OnOpen callback) {
  opening_ = std::move(callback);
  link.start({[this] { opened(); }, [this](std::span<const std::uint8_t> b) { received(b); },
              [this](const Error& error) { return lost(error); }, [this] { finished(); }},
             shared_from_this());
}

// --- the beginning of every connection -----------------------------------------------------------

void Connection::Impl::opened() {
  const std::lock_guard lock(mutex);
  going_away_.clear();
  hello_ = say(protocol::Hello{protocol::kProtocolMin, protocol::kProtocolMax, "culld-client",
                               protocol::kFeatureCancel | protocol::kFeatureDeadlines});
  waiting_.emplace(hello_, [this](Reply reply) { welcomed(std::move(reply)); });
}

void Connection::Impl::welcomed(Reply reply) {
  if (!reply) return link.breakOff(reply.error());
  const auto* welcome = std::get_if<protocol::Welcome>(&reply.value());
  if (welcome == nullptr) {
    return link.breakOff({ErrorCode::kUnavailable, name + ": unexpected reply"});
  }
  link.established();
  Calls calls;
  std::vector<ViewPtr> held;  // released after the lock: their end takes the lock
  {
    const std::lock_guard lock(mutex);
    if (ended_) return;
    state = ConnectionState::kConnected;
    connected_since_ = std::chrono::steady_clock::now();
    if (opening_) {
      if (scene.name.empty()) scene = welcome->scene;  // else a newer word came already
      calls.push_back([self = shared_from_this(), callback = std::exchange(opening_, {})] {
        callback(std::unique_ptr<Connection>(new Connection(self)));
      });
    } else {
      // Nobody knows what became of the ids meanwhile, unless it is the scene that it was.
      const bool other = !(scene == welcome->scene);
      scene = welcome->scene;
      calls.push_back([this] { tellState(ConnectionState::kConnected, {}); });
      if (other) calls.push_back([this, now = scene] { tellScene(now, true); });
      held = livingViews();
      for (const ViewPtr& view : held) reopen(view);
    }
  }
  makeAll(calls);
}

void Connection::Impl::makeAll(const Calls& calls) {
  for (const auto& call : calls) call();
}

void Connection::Impl::tellState(ConnectionState now, const Error& reason) {
  std::unique_lock lock(mutex);
  const auto callback = state_callback;
  lock.unlock();
  if (callback) callback(now, reason);
}

void Connection::Impl::tellScene(const SceneInfo& now, bool replaced) {
  std::unique_lock lock(mutex);
  const auto callback = scene_callback;
  lock.unlock();
  if (callback) callback(now, replaced);
}

void Connection::Impl::reopen(const ViewPtr& view) {
  if (!view->given) return;
  const auto id = say(protocol::OpenView{view->number, view->asked_method, view->want_seen});
  waiting_.emplace(id, [this, weak = std::weak_ptr(view)](const Reply& reply) {
    if (const ViewPtr opened = weak.lock()) reopened(opened, reply);
  });
}

void Connection::Impl::reopened(const ViewPtr& view, const Reply& reply) {
  std::deque<View::State::Pending> refused;
  {
    const std::lock_guard lock(mutex);
    if (state != ConnectionState::kConnected) return;  // lost again; the next one opens it
    if (reply) {
      view->open = true;
      if (view->last) askLast(*view, 0);
      return;
    }
    view->refused = reply.error();
    refused = std::exchange(view->pending, {});
  }
  for (const auto& pending : refused) pending.answer(reply.error());
}

// --- what the program asks -----------------------------------------------------------------------

std::uint64_t Connection::Impl::say(protocol::Body body) {
  const std::uint64_t id = next_request_++;
  link.send(protocol::encode({id, std::move(body)}));
  return id;
}

void Connection::Impl::request(protocol::Body body, OnReply callback) {
  std::optional<Error> refused;
  {
    const std::lock_guard lock(mutex);
    if (state == ConnectionState::kConnected) {
      waiting_.emplace(say(std::move(body)), std::move(callback));
      return;
    }
    refused = ended_ ? *ended_ : Error{ErrorCode::kUnavailable, name + ": not connected"};
  }
  callback(*std::move(refused));
}

std::optional<Error> Connection::Impl::refuseWait() const {
  if (!link.onThread()) return std::nullopt;
  return protocol::invalidInput(name + ": a call that waits, in a callback, would wait for itself");
}

std::uint64_t Connection::Impl::setCamera(const ViewPtr& view, const Camera& camera,
                                          const Demand& demand, OnAnswer callback) {
  constexpr std::size_t kMaxWaiting = 1024;
  std::optional<Error> refused;
  std::uint64_t number = 0;
  {
    const std::lock_guard lock(mutex);
    number = ++view->last_camera;
    refused = ended_ ? ended_ : view->refused;
    if (!refused) {
      view->last = protocol::CameraUpdate{view->number, camera, demand, 0, view->deadline_us};
      view->pending.push_back({0, number, 0, std::move(callback)});
      if (view->open) askLast(*view, view->history.newestNumber());
      if (view->pending.size() <= kMaxWaiting) return number;
      passed_over_.push_back([answer = std::move(view->pending.front().answer), who = name] {
        answer(Error{ErrorCode::kUnavailable, who + ": too many newer cameras wait"});
      });
      view->pending.pop_front();
    }
  }
  if (refused) {
    callback(*refused);
  } else {
    tellPassedOver();
  }
  return number;
}

void Connection::Impl::tellPassedOver() {
  link.post([this] {
    std::unique_lock lock(mutex);
    const Calls calls = std::exchange(passed_over_, {});
    lock.unlock();
    makeAll(calls);
  });
}

/// The newest camera, which all that wait are content with.
std::uint64_t Connection::Impl::askLast(View::State& view, std::uint32_t acknowledged) {
  view.last->ack_frame = acknowledged;
  const std::uint64_t id = say(*view.last);
  if (view.pending.empty()) return id;
  view.pending.back().request = id;
  view.pending.back().acknowledged = acknowledged;
  return id;
}

void Connection::Impl::cancel(View::State& view) {
  const std::lock_guard lock(mutex);
  if (!view.open || view.pending.empty()) return;
  say(protocol::Cancel{view.pending.back().request});
}

void Connection::Impl::openView(const ViewPtr& view, OnView callback) {
  {
    const std::lock_guard lock(mutex);
    view->number = next_view++;
    views[view->number] = view;
  }
  request(protocol::OpenView{view->number, view->asked_method, view->want_seen},
          [this, view, callback = std::move(callback)](Reply reply) {
            if (!reply) return callback(std::move(reply).error());
            const auto* opened = std::get_if<protocol::ViewOpened>(&reply.value());
            if (opened == nullptr) {
              return callback(Error{ErrorCode::kUnavailable, name + ": unexpected reply"});
            }
            {
              const std::lock_guard lock(mutex);
              view->method = opened->method;
              view->guarantee = opened->guarantee;
              view->given = view->open = true;
            }
            callback(View(view));
          });
}

void Connection::Impl::closeView(View::State& view) {
  {
    const std::lock_guard lock(mutex);
    views.erase(view.number);
    if (state == ConnectionState::kConnected) say(protocol::CloseView{view.number});
    if (view.pending.empty()) return;
    for (auto& pending : std::exchange(view.pending, {})) {
      passed_over_.push_back([answer = std::move(pending.answer), who = name] {
        answer(Error{ErrorCode::kCancelled, who + ": the view was closed"});
      });
    }
  }
  tellPassedOver();
}

std::vector<Connection::Impl::ViewPtr> Connection::Impl::livingViews() {
  std::vector<ViewPtr> living;
  for (const auto& [number, weak] : views) {
    if (ViewPtr view = weak.lock()) living.push_back(std::move(view));
  }
  return living;
}

// --- the end -------------------------------------------------------------------------------------

/// Fails what waits: all of it, or all but cameras.
void Connection::Impl::giveUp(const Error& why, bool cameras_too, Calls& calls) {
  waiting_.erase(hello_);
  for (auto& [id, callback] : std::exchange(waiting_, {})) {
    calls.push_back([callback = std::move(callback), why] { callback(why); });
  }
  for (const ViewPtr& view : livingViews()) {
    view->open = false;
    view->refused.reset();
    view->whole_request = 0;
    view->history.forgetAll();
    calls.push_back([view] {});  // released after the lock: its end takes the lock
    for (auto& pending : view->pending) pending.request = 0;
    if (!cameras_too) continue;
    for (auto& pending : std::exchange(view->pending, {})) {
      calls.push_back([answer = std::move(pending.answer), why] { answer(why); });
    }
  }
  if (!cameras_too) return;
  for (auto& call : std::exchange(passed_over_, {})) calls.push_back(std::move(call));
  if (opening_) {
    calls.push_back([callback = std::exchange(opening_, {}), why] { callback(why); });
  }
}

/// How long to wait for it; none: the connection has ended.
std::optional<milliseconds> Connection::Impl::nextAttempt(const Error& error) {
  if (opening_) return std::nullopt;                               // the first one is tried once
  if (error.code != ErrorCode::kUnavailable) return std::nullopt;  // would be said again
  if (state == ConnectionState::kConnected) {
    backoff_.held(std::chrono::steady_clock::now() - connected_since_);
  }
  return backoff_.next();
}

std::optional<milliseconds> Connection::Impl::lost(const Error& error) {
  std::optional<milliseconds> wait;
  Calls calls;
  {
    const std::lock_guard lock(mutex);
    if (ended_) return std::nullopt;
    Error why = error;
    if (!going_away_.empty()) why.message = name + ": server went away: " + going_away_;
    wait = nextAttempt(error);
    const auto now = wait ? ConnectionState::kReconnecting : ConnectionState::kEnded;
    if (!wait) ended_ = why;
    giveUp(why, !wait, calls);
    if (std::exchange(state, now) != now) {
      calls.push_back([this, now, why] { tellState(now, why); });
    }
  }
  makeAll(calls);
  return wait;
}

void Connection::Impl::finished() {
  Calls calls;
  {
    const std::lock_guard lock(mutex);
    giveUp(*ended_, true, calls);
  }
  makeAll(calls);
}

void Connection::Impl::close() {
  {
    const std::lock_guard lock(mutex);
    if (!ended_) ended_ = Error{ErrorCode::kUnavailable, name + ": connection closed"};
    state = ConnectionState::kEnded;
  }
  if (link.onThread()) finished();
  link.close();
}

}  // namespace culld::client
