#include "culld/connection.h"

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>

#include "client/sdk/connection_impl.h"
#include "protocol/limits.h"

namespace culld::client {
namespace {

Error unexpectedReply(const std::string& name) {
  return {ErrorCode::kUnavailable, name + ": unexpected reply"};
}

/// A message that is too large would end the connection.
std::optional<Error> tooManyPairs(std::size_t viewers, std::size_t targets) {
  constexpr std::size_t kMostPlaces = (protocol::kMaxRequestBytes - 256) / (7 * sizeof(double));
  if (viewers > kMostPlaces || targets > kMostPlaces || viewers + targets > kMostPlaces) {
    return Error{ErrorCode::kLimit,
                 "pairs: more than " + std::to_string(kMostPlaces) + " viewers and targets"};
  }
  if (viewers * targets <= protocol::kMaxPairs) return std::nullopt;
  return Error{ErrorCode::kLimit, "pairs: " + std::to_string(viewers) + " viewers x " +
                                      std::to_string(targets) + " targets > " +
                                      std::to_string(protocol::kMaxPairs)};
}

/// A callback that fills a future, and the future.
template <typename T>
auto promised() {
  auto promise = std::make_shared<std::promise<Result<T>>>();
  auto future = promise->get_future();
  return std::pair([promise](Result<T> result) { promise->set_value(std::move(result)); },
                   std::move(future));
}

template <typename T>
Result<T> await(std::future<Result<T>>& future, const Connection::Impl& impl, const char* what) {
  const auto limit = impl.options.timeouts.reply;
  if (future.wait_for(limit) == std::future_status::ready) return future.get();
  return Error{ErrorCode::kUnavailable,
               impl.name + ": no " + what + " within " + std::to_string(limit.count()) + " ms"};
}

}  // namespace

Connection::Connection(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

Connection::~Connection() {
  onState({});
  onSceneChanged({});
  impl_->close();
  if (!impl_->link.onThread()) impl_->link.join();
}

void Connection::open(const Address& address, const std::string& scene,
                      const ConnectOptions& options, OnOpen callback) {
  auto impl = std::make_shared<Impl>(address, scene, options);
  impl->start(std::move(callback));
}

Result<std::unique_ptr<Connection>> Connection::open(const Address& address,
                                                     const std::string& scene,
                                                     const ConnectOptions& options) {
  auto [callback, opened] = promised<std::unique_ptr<Connection>>();
  const auto impl = std::make_shared<Impl>(address, scene, options);
  impl->start(std::move(callback));
  auto connection = opened.get();  // every step has its limit
  if (!connection) impl->link.join();
  return connection;
}

void Connection::close() { impl_->close(); }

void Connection::openView(const std::string& method, bool want_seen, OnView callback) {
  auto state = std::make_shared<View::State>();
  state->connection = impl_;
  state->asked_method = method;
  state->want_seen = want_seen;
  impl_->openView(state, std::move(callback));
}

Result<View> Connection::openView(const std::string& method, bool want_seen) {
  if (auto refused = impl_->refuseWait()) return *std::move(refused);
  auto [callback, opened] = promised<View>();
  openView(method, want_seen, std::move(callback));
  return await(opened, *impl_, "reply");
}

void Connection::edit(std::vector<EditItem> edits, std::uint64_t expected_version,
                      OnEdited callback) {
  impl_->request(protocol::Edit{expected_version, std::move(edits)},
                 [name = impl_->name, callback = std::move(callback)](const Impl::Reply& reply) {
                   if (!reply) return callback(reply.error());
                   const auto* edited = std::get_if<protocol::Edited>(&reply.value());
                   if (edited == nullptr) return callback(unexpectedReply(name));
                   callback(EditOutcome{edited->scene_version, edited->added});
                 });
}

Result<EditOutcome> Connection::edit(std::vector<EditItem> edits, std::uint64_t expected_version) {
  if (auto refused = impl_->refuseWait()) return *std::move(refused);
  auto [callback, edited] = promised<EditOutcome>();
  edit(std::move(edits), expected_version, std::move(callback));
  return await(edited, *impl_, "reply");
}

void Connection::pairs(std::vector<Place> viewers, std::vector<Place> targets,
                       std::chrono::microseconds time, OnPairs callback) {
  const auto us = std::clamp<std::int64_t>(time.count(), 0, 0xFFFFFFFF);
  const std::size_t asked_viewers = viewers.size(), asked_targets = targets.size();
  if (const auto many = tooManyPairs(asked_viewers, asked_targets)) return callback(*many);
  impl_->request(
      protocol::Pairs{std::move(viewers), std::move(targets), static_cast<std::uint32_t>(us)},
      [name = impl_->name, asked_viewers, asked_targets,
       callback = std::move(callback)](const Impl::Reply& reply) {
        if (!reply) return callback(reply.error());
        const auto* answer = std::get_if<protocol::PairsAnswer>(&reply.value());
        const bool fits = answer != nullptr && answer->viewers == asked_viewers &&
                          answer->targets == asked_targets;
        if (!fits) return callback(unexpectedReply(name));
        callback(PairsOutcome{answer->scene_version, answer->viewers, answer->targets,
                              answer->may_see, answer->out_of_budget,
                              std::chrono::nanoseconds(answer->cull_ns),
                              std::chrono::nanoseconds(answer->queue_ns)});
      });
}

Result<PairsOutcome> Connection::pairs(std::vector<Place> viewers, std::vector<Place> targets,
                                       std::chrono::microseconds time) {
  if (auto refused = impl_->refuseWait()) return *std::move(refused);
  auto [callback, answered] = promised<PairsOutcome>();
  pairs(std::move(viewers), std::move(targets), time, std::move(callback));
  return await(answered, *impl_, "reply");
}

void Connection::ping(OnPong callback) {
  const auto start = std::chrono::steady_clock::now();
  impl_->request(protocol::Ping{1}, [name = impl_->name, start,
                                     callback = std::move(callback)](const Impl::Reply& reply) {
    if (!reply) return callback(reply.error());
    if (!std::holds_alternative<protocol::Pong>(reply.value())) {
      return callback(unexpectedReply(name));
    }
    callback(std::chrono::nanoseconds(std::chrono::steady_clock::now() - start));
  });
}

Result<std::chrono::nanoseconds> Connection::ping() {
  if (auto refused = impl_->refuseWait()) return *std::move(refused);
  auto [callback, pong] = promised<std::chrono::nanoseconds>();
  ping(std::move(callback));
  return await(pong, *impl_, "reply");
}

SceneInfo Connection::scene() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->scene;
}

ConnectionState Connection::state() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->state;
}

// What a callback holds may end with it, and call back here: the old one goes after the lock.
void Connection::onSceneChanged(std::function<void(const SceneInfo&, bool)> callback) {
  const std::lock_guard lock(impl_->mutex);
  impl_->scene_callback.swap(callback);
}

void Connection::onState(std::function<void(ConnectionState, const Error&)> callback) {
  const std::lock_guard lock(impl_->mutex);
  impl_->state_callback.swap(callback);
}

View::View(std::shared_ptr<State> state) : state_(std::move(state)) {}

std::uint64_t View::setCamera(const Camera& camera, const Demand& demand, OnAnswer callback) {
  return state_->connection->setCamera(state_, camera, demand, std::move(callback));
}

std::future<Result<FramePtr>> View::setCamera(const Camera& camera, const Demand& demand) {
  auto [callback, answer] = promised<FramePtr>();
  setCamera(camera, demand, std::move(callback));
  return std::move(answer);
}

Result<FramePtr> View::cull(const Camera& camera, const Demand& demand) {
  if (auto refused = state_->connection->refuseWait()) return *std::move(refused);
  auto answer = setCamera(camera, demand);
  return await(answer, *state_->connection, "answer");
}

void View::cancel() { state_->connection->cancel(*state_); }

void View::setDeadline(std::chrono::microseconds deadline) {
  const auto us = std::clamp<std::int64_t>(deadline.count(), 0, 0xFFFFFFFF);
  const std::lock_guard lock(state_->connection->mutex);
  state_->deadline_us = static_cast<std::uint32_t>(us);
}

void View::onFrame(OnFrame callback) {
  const std::lock_guard lock(state_->connection->mutex);
  state_->callback.swap(callback);
}

FramePtr View::newest() const {
  const std::lock_guard lock(state_->connection->mutex);
  return state_->newest;
}

std::uint64_t View::misfits() const {
  const std::lock_guard lock(state_->connection->mutex);
  return state_->misfits;
}

const std::string& View::method() const { return state_->method; }

Guarantee View::guarantee() const { return state_->guarantee; }

View::State::~State() { connection->closeView(*this); }

}  // namespace culld::client
