// A WebSocket around a Session: moves bytes, runs jobs, counts. The session decides everything.
#include <algorithm>
#include <boost/asio/buffer.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <memory>
#include <utility>

#include "protocol/version.h"
#include "server/client_stream.h"
#include "server/connections.h"
#include "server/message_rate.h"
#include "server/scene_names.h"
#include "server/session.h"
#include "server/session_log.h"

namespace culld::server {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;
namespace asio = boost::asio;

/// A cull that takes less than handing it to another thread and back runs where it came in: the two
/// wake-ups of a halted core measured 20 to 25 us each.
constexpr std::chrono::microseconds kInlineCull{100};

class LiveConnection final : public LivePeer, public std::enable_shared_from_this<LiveConnection> {
 public:
  LiveConnection(ClientStream stream, LiveRequest request, Context& context)
      : context_(context),
        log_(std::make_shared<SessionLog>(request.caller.name, request.scene->name(),
                                          stream.get_executor(), context)),
        caller_(std::move(request.caller)),
        grant_(std::move(request.grant)),
        socket_(std::move(stream)),
        session_timer_(socket_.get_executor()),
        write_timer_(socket_.get_executor()),
        rate_timer_(socket_.get_executor()),
        rate_(context.limits.session.max_messages_per_s),
        request_(std::move(request.bytes)),
        session_(request.scene, context.limits.session, context.server_name, context.clock.now(),
                 rightsIn(*request.scene)) {
    context_.live.insert(this);
    context_.metrics.sessionOpened();
    context_.metrics.connectionOpened();
  }

  ~LiveConnection() override {
    context_.live.erase(this);
    context_.queued_bytes -= outbox_bytes_;
    context_.metrics.viewsChanged(-static_cast<std::ptrdiff_t>(counted_views_));
    context_.metrics.sessionClosed();
    context_.metrics.connectionClosed();
  }

  void start() {
    const ServerLimits& limits = context_.limits;
    socket_.set_option(
        websocket::stream_base::timeout{limits.header_timeout, limits.session.idle_timeout, true});
    socket_.set_option(websocket::stream_base::decorator(
        [name = context_.server_name](websocket::response_type& response) {
          response.set(beast::http::field::server, name);
          response.set(beast::http::field::sec_websocket_protocol, protocol::kSubprotocol);
        }));
    socket_.read_message_max(limits.session.max_message_bytes);
    socket_.auto_fragment(false);
    socket_.binary(true);
    socket_.async_accept(asio::buffer(request_),
                         [self = shared_from_this()](beast::error_code failure) {
                           if (failure || self->ended_) return self->end();
                           self->accepted_ = true;
                           self->log_->opened();
                           self->request_ = {};
                           self->awaitTick();
                           self->read();
                         });
  }

  // LivePeer
  const std::shared_ptr<Scene>& scene() const override { return session_.scene(); }
  std::size_t viewCount() const override { return session_.viewCount(); }
  bool stillWelcome() const override { return context_.access.stillGood(grant_, caller_.peer); }
  void sceneMoved() override { apply(session_.sceneMoved()); }
  void goAway(const std::string& reason) override {
    if (!accepted_) return end();
    leaving_ = Close{static_cast<std::uint16_t>(websocket::close_code::going_away), reason};
    apply(session_.goAway(reason));
  }

 private:
  SessionRights rightsIn(const Scene& scene) const {
    SessionRights rights{grant_.tenant, ""};
    if (grant_.scope < Scope::kEdit) {
      rights.edit_refusal = "the token has not the scope edit";
    } else if (ownerOf(scene.name()) != grant_.tenant->name()) {
      rights.edit_refusal = "the scene is the operator's, not this tenant's";
    }
    return rights;
  }

  /// The session says when time matters to it: at first for Hello, then for deadlines.
  void awaitTick() {
    const auto next = session_.nextTick();
    if (next == awaited_tick_ || ended_) return;
    awaited_tick_ = next;
    session_timer_.cancel();
    if (!next) return;
    session_timer_.expires_after(*next - context_.clock.now());
    session_timer_.async_wait([weak = weak_from_this()](beast::error_code failure) {
      const auto self = weak.lock();
      if (!self || failure) return;
      self->awaited_tick_.reset();
      self->apply(self->session_.tick(self->context_.clock.now()));
    });
  }

  void read() {
    reading_ = true;
    socket_.async_read(inbox_,
                       [self = shared_from_this()](beast::error_code failure, std::size_t bytes) {
                         self->reading_ = false;
                         if (failure) return self->end(failure);
                         self->received(bytes);
                       });
  }

  void received(std::size_t bytes) {
    context_.metrics.received(bytes);
    log_->received(bytes);
    const asio::const_buffer data = inbox_.cdata();
    Actions actions =
        socket_.got_text()
            ? session_.receiveText()
            : session_.receive({static_cast<const std::uint8_t*>(data.data()), data.size()},
                               context_.clock.now());
    inbox_.consume(inbox_.size());
    apply(std::move(actions));
    const auto wait = rate_.count(context_.clock.now());
    if (wait > std::chrono::nanoseconds(0)) return readLater(wait);
    readOn();
  }

  /// Who talks faster than the limit is read more slowly.
  void readLater(std::chrono::nanoseconds wait) {
    reading_ = true;
    rate_timer_.expires_after(wait);
    rate_timer_.async_wait([self = shared_from_this()](beast::error_code) {
      self->reading_ = false;
      self->readOn();
    });
  }

  /// A client that does not take its replies is not listened to.
  void readOn() {
    const ServerLimits& limits = context_.limits;
    const bool room = outbox_.size() < limits.queued_messages &&
                      outbox_bytes_ < limits.queued_bytes &&
                      (outbox_.empty() || context_.queued_bytes < limits.total_queued_bytes);
    if (!reading_ && room && !ended_ && !closing_) read();
  }

  void apply(Actions actions) {
    // Jobs that run here make further actions, so this is a queue and not a recursion.
    std::deque<Action> todo(std::make_move_iterator(actions.begin()),
                            std::make_move_iterator(actions.end()));
    while (!todo.empty()) {
      Action action = std::move(todo.front());
      todo.pop_front();
      Actions more = perform(std::move(action));
      std::move(more.begin(), more.end(), std::back_inserter(todo));
    }
    countViews();
    write();
    awaitTick();
  }

  Actions perform(Action action) {
    if (auto* send = std::get_if<Send>(&action)) {
      if (send->error != protocol::WireCode::kNone) {
        context_.metrics.refused(send->error);
        log_->refused(send->error);
      }
      countSent(*send);
      outbox_bytes_ += send->bytes.size();
      context_.queued_bytes += send->bytes.size();
      outbox_.push_back(std::move(*send));
    } else if (auto* cull = std::get_if<StartCull>(&action)) {
      return startCull(std::move(cull->job));
    } else if (auto* edit = std::get_if<StartEdit>(&action)) {
      startEdit(std::move(edit->job));
    } else if (auto* pairs = std::get_if<StartPairs>(&action)) {
      startPairs(std::move(pairs->job));
    } else {
      leaving_ = *std::get_if<Close>(&action);
    }
    return {};
  }

  Actions startCull(CullJob job) {
    const bool quick = job.expected.count() > 0 && job.expected < kInlineCull;
    if (quick) return culled(runCull(std::move(job), context_.clock));
    // The worker hands its share of this connection on, so that the connection ends on its thread.
    context_.workers.post(
        grant_.tenant->name(), [self = shared_from_this(), job = std::move(job)]() mutable {
          Context& context = self->context_;
          auto outcome = std::make_shared<CullOutcome>(runCull(std::move(job), context.clock));
          context.onIoThread([self = std::move(self), outcome] {
            self->apply(self->culled(std::move(*outcome)));
          });
        });
    return {};
  }

  Actions culled(CullOutcome outcome) {
    const AnswerReport report = std::move(outcome.report);
    const std::uint32_t superseded = outcome.job.superseded;
    Actions actions = session_.culled(std::move(outcome));
    const bool answers = std::any_of(actions.begin(), actions.end(), [](const Action& action) {
      const auto* send = std::get_if<Send>(&action);
      return send != nullptr && send->tag.kind == SendTag::Kind::kAnswer;
    });
    if (answers) {
      context_.metrics.answered(report);
      log_->answered(report.bytes);
      context_.metrics.superseded(superseded);
    }
    grant_.tenant->culled(report.cull, context_.clock.now());
    return actions;
  }

  void startPairs(PairsJob job) {
    context_.workers.post(grant_.tenant->name(), [self = shared_from_this(),
                                                  job = std::move(job)]() mutable {
      Context& context = self->context_;
      auto outcome = std::make_shared<PairsOutcome>(runPairs(std::move(job), context.clock));
      context.onIoThread([self = std::move(self), outcome] { self->paired(std::move(*outcome)); });
    });
  }

  void paired(PairsOutcome outcome) {
    context_.metrics.paired(outcome.pairs, outcome.hidden, outcome.took);
    grant_.tenant->culled(outcome.took, context_.clock.now());
    apply(session_.paired(std::move(outcome)));
  }

  void startEdit(EditJob job) {
    context_.edits.post(
        session_.scene(), std::move(job), [self = shared_from_this()](EditDone outcome) mutable {
          Context& context = self->context_;
          auto done = std::make_shared<EditDone>(std::move(outcome));
          context.onIoThread([self = std::move(self), done] { self->edited(std::move(*done)); });
        });
  }

  void edited(EditDone done) {
    const bool changed = done.changed;
    apply(session_.edited(std::move(done)));
    if (!changed) return;
    context_.metrics.edited();
    log_->edited();
    context_.sceneMoved(session_.scene().get());
  }

  void countSent(const Send& send) {
    if (send.quota) context_.metrics.quotaRejected(nameOf(*send.quota));
    // What is refused costs nothing: a client that asks on and on would never come out of debt.
    if (send.error == protocol::WireCode::kNone) {
      grant_.tenant->sent(send.bytes.size(), context_.clock.now());
    }
  }

  void countViews() {
    const std::size_t views = session_.viewCount();
    if (views == counted_views_) return;
    context_.metrics.viewsChanged(static_cast<std::ptrdiff_t>(views) -
                                  static_cast<std::ptrdiff_t>(counted_views_));
    counted_views_ = views;
  }

  void write() {
    if (writing_ || ended_ || closing_) return;
    if (outbox_.empty()) {
      if (leaving_ && (session_.drained() || !session_.greeted())) close();
      return;
    }
    writing_ = true;
    write_begun_ = context_.clock.now();
    if (!watching_writes_) watchWrites(timeToWrite());
    socket_.async_write(asio::buffer(outbox_.front().bytes),
                        [self = shared_from_this()](beast::error_code failure, std::size_t) {
                          self->writing_ = false;
                          if (failure) return self->end(failure);
                          self->written();
                        });
  }

  /// For the message that is being sent; a large one may take as long as an upload of its size.
  std::chrono::nanoseconds timeToWrite() const {
    const ServerLimits& limits = context_.limits;
    return limits.write_timeout +
           std::chrono::seconds(outbox_.front().bytes.size() /
                                std::max<std::uint64_t>(1, limits.min_upload_bytes_per_s));
  }

  /// One timer for all messages: it is set again only when it has run out.
  void watchWrites(std::chrono::nanoseconds wait) {
    watching_writes_ = true;
    write_timer_.expires_after(wait);
    write_timer_.async_wait([weak = weak_from_this()](beast::error_code failure) {
      const auto self = weak.lock();
      if (!self || failure) return;
      self->watching_writes_ = false;
      if (!self->writing_) return;
      const auto left = self->write_begun_ + self->timeToWrite() - self->context_.clock.now();
      if (left <= std::chrono::nanoseconds(0)) return self->end(beast::error::timeout);
      self->watchWrites(left);
    });
  }

  void written() {
    const SendTag tag = outbox_.front().tag;
    outbox_bytes_ -= outbox_.front().bytes.size();
    context_.queued_bytes -= outbox_.front().bytes.size();
    outbox_.pop_front();
    apply(session_.sent(tag));
    readOn();
  }

  void close() {
    closing_ = true;
    websocket::close_reason why;
    why.code = leaving_->code;
    why.reason = leaving_->reason.substr(0, 100);  // a close frame holds 123 bytes
    socket_.async_close(why, [self = shared_from_this()](beast::error_code) { self->end(); });
  }

  void end(beast::error_code failure = {}) {
    log_->closed(leaving_ ? leaving_->reason : failure ? failure.message() : "closed");
    ended_ = true;
    session_timer_.cancel();
    write_timer_.cancel();
    rate_timer_.cancel();
    session_.hangUp();
    beast::get_lowest_layer(socket_).close();
  }

  Context& context_;
  const std::shared_ptr<SessionLog> log_;
  const Caller caller_;
  const Grant grant_;
  websocket::stream<ClientStream> socket_;
  asio::steady_timer session_timer_;
  asio::steady_timer write_timer_;
  asio::steady_timer rate_timer_;
  MessageRate rate_;
  std::optional<Time> awaited_tick_;
  Time write_begun_{0};
  std::string request_;
  Session session_;
  beast::flat_buffer inbox_;
  std::deque<Send> outbox_;
  std::size_t outbox_bytes_ = 0;
  std::size_t counted_views_ = 0;
  std::optional<Close> leaving_;
  bool accepted_ = false;
  bool reading_ = false;
  bool writing_ = false;
  bool watching_writes_ = false;
  bool closing_ = false;
  bool ended_ = false;
};

}  // namespace

void serveLive(ClientStream stream, LiveRequest request, Context& context) {
  std::make_shared<LiveConnection>(std::move(stream), std::move(request), context)->start();
}

}  // namespace culld::server
