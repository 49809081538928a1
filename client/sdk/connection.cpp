#include "culld/connection.h"

#include <utility>

#include "client/sdk/connection_impl.h"
#include "client/sdk/dial.h"
#include "protocol/codec.h"
#include "protocol/version.h"

namespace culld::client {
namespace {

Error unexpectedReply(const std::string& name) {
  return {ErrorCode::kUnavailable, name + ": unexpected reply"};
}

}  // namespace

Connection::Connection(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

Connection::~Connection() {
  impl_->lost({ErrorCode::kUnavailable, "connection closed"});
  std::unique_ptr<LiveSocket> socket;
  {
    const std::lock_guard lock(impl_->mutex);
    socket = std::move(impl_->socket);
  }
  socket.reset();  // joins its thread, which may still take the lock
}

Result<std::unique_ptr<Connection>> Connection::open(const Address& address,
                                                     const std::string& scene,
                                                     const Timeouts& timeouts) {
  auto socket =
      LiveSocket::connect(address, "/v1/scenes/" + percentEncoded(scene) + "/live", timeouts);
  if (!socket) return std::move(socket).error();
  auto impl = std::make_shared<Impl>();
  impl->name = toString(address);
  impl->timeouts = timeouts;
  impl->socket = std::move(socket).value();
  std::unique_ptr<Connection> connection(new Connection(impl));
  impl->socket->start({[raw = impl.get()](std::span<const std::uint8_t> b) { raw->received(b); },
                       [raw = impl.get()](const Error& error) { raw->lost(error); }});

  const protocol::Hello hello{protocol::kProtocolMin, protocol::kProtocolMax, "culld-client"};
  auto reply = impl->call(hello, timeouts.connect);
  if (!reply) return std::move(reply).error();
  const auto* welcome = std::get_if<protocol::Welcome>(&reply.value());
  if (welcome == nullptr) return unexpectedReply(impl->name);
  const std::lock_guard lock(impl->mutex);
  if (impl->scene.name.empty()) impl->scene = welcome->scene;  // else a newer word came already
  return connection;
}

Result<View> Connection::openView(const std::string& method, bool want_seen) {
  auto state = std::make_shared<View::State>();
  state->connection = impl_;
  {
    const std::lock_guard lock(impl_->mutex);
    state->number = impl_->next_view++;
    impl_->views[state->number] = state;
  }
  auto reply =
      impl_->call(protocol::OpenView{state->number, method, want_seen}, impl_->timeouts.reply);
  if (!reply) return std::move(reply).error();
  const auto* opened = std::get_if<protocol::ViewOpened>(&reply.value());
  if (opened == nullptr) return unexpectedReply(impl_->name);
  state->method = opened->method;
  state->guarantee = opened->guarantee;
  return View(std::move(state));
}

Result<EditOutcome> Connection::edit(std::vector<EditItem> edits, std::uint64_t expected_version) {
  auto reply =
      impl_->call(protocol::Edit{expected_version, std::move(edits)}, impl_->timeouts.reply);
  if (!reply) return std::move(reply).error();
  const auto* edited = std::get_if<protocol::Edited>(&reply.value());
  if (edited == nullptr) return unexpectedReply(impl_->name);
  return EditOutcome{edited->scene_version, edited->added};
}

Result<std::chrono::nanoseconds> Connection::ping() {
  const auto start = std::chrono::steady_clock::now();
  const auto reply = impl_->call(protocol::Ping{1}, impl_->timeouts.reply);
  if (!reply) return reply.error();
  if (!std::holds_alternative<protocol::Pong>(reply.value())) return unexpectedReply(impl_->name);
  return std::chrono::nanoseconds(std::chrono::steady_clock::now() - start);
}

SceneInfo Connection::scene() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->scene;
}

void Connection::onSceneChanged(std::function<void(const SceneInfo&, bool)> callback) {
  const std::lock_guard lock(impl_->mutex);
  impl_->scene_callback = std::move(callback);
}

View::View(std::shared_ptr<State> state) : state_(std::move(state)) {}

std::future<Result<FramePtr>> View::setCamera(const Camera& camera, const Demand& demand) {
  Connection::Impl& connection = *state_->connection;
  const std::lock_guard lock(connection.mutex);
  State::Pending pending;
  auto future = pending.answer.get_future();
  if (connection.ended) {
    pending.answer.set_value(*connection.ended);
    return future;
  }
  pending.request = connection.next_request++;
  pending.acknowledged = state_->history.newestNumber();
  state_->last = protocol::CameraUpdate{state_->number, camera, demand, pending.acknowledged};
  connection.socket->send(protocol::encode({pending.request, *state_->last}));
  state_->pending.push_back(std::move(pending));
  return future;
}

Result<FramePtr> View::cull(const Camera& camera, const Demand& demand) {
  auto future = setCamera(camera, demand);
  const auto limit = state_->connection->timeouts.reply;
  if (future.wait_for(limit) == std::future_status::ready) return future.get();
  return Error{ErrorCode::kUnavailable, state_->connection->name + ": no answer within " +
                                            std::to_string(limit.count()) + " ms"};
}

void View::onFrame(std::function<void(const FramePtr&)> callback) {
  const std::lock_guard lock(state_->connection->mutex);
  state_->callback = std::move(callback);
}

FramePtr View::newest() const {
  const std::lock_guard lock(state_->connection->mutex);
  return state_->newest;
}

const std::string& View::method() const { return state_->method; }

Guarantee View::guarantee() const { return state_->guarantee; }

View::State::~State() {
  const std::lock_guard lock(connection->mutex);
  connection->views.erase(number);
  if (connection->ended || connection->socket == nullptr) return;
  connection->socket->send(
      protocol::encode({connection->next_request++, protocol::CloseView{number}}));
}

}  // namespace culld::client
