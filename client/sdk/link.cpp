#include "client/sdk/link.h"

#include <boost/asio/post.hpp>
#include <utility>

namespace culld::client {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

constexpr std::chrono::seconds kFarewell{1};  // for a server that does not answer the goodbye

}  // namespace

Link::Link(Address address, std::string target, ConnectOptions options)
    : address_(std::move(address)), target_(std::move(target)), options_(std::move(options)) {}

Link::~Link() {
  if (!thread_.joinable()) return;
  if (onThread()) {
    thread_.detach();
  } else {
    thread_.join();
  }
}

void Link::start(Handlers handlers, std::shared_ptr<void> owner) {
  handlers_ = std::move(handlers);
  asio::post(io_, [this] { connect(); });
  thread_ = std::thread([this, owner = std::move(owner)] {
    thread_id_ = std::this_thread::get_id();
    io_.run();
  });
}

void Link::send(std::vector<std::uint8_t> bytes) {
  {
    const std::lock_guard lock(outbox_mutex_);
    outbox_.push_back(std::move(bytes));
    if (outbox_.size() > 1) return;  // the one before will take it along
  }
  asio::post(io_, [this] { flush(); });
}

/// What is to be sent passes through a queue of our own: tasks that the io_context is given by its
/// own thread may overtake those of others, and cameras must keep their order.
void Link::flush() {
  std::vector<std::vector<std::uint8_t>> messages;
  {
    const std::lock_guard lock(outbox_mutex_);
    messages.swap(outbox_);
  }
  if (socket_ == nullptr) return;
  for (auto& message : messages) socket_->send(std::move(message));
}

void Link::post(std::function<void()> task) { asio::post(io_, std::move(task)); }

void Link::close() {
  asio::post(io_, [this] {
    if (std::exchange(closing_, true)) return;
    handlers_.ended();
    if (socket_ == nullptr) return finish();
    after(kFarewell, [this] { finish(); });
    socket_->close();
  });
}

void Link::join() {
  if (thread_.joinable()) thread_.join();
}

void Link::established() { forgetTimer(); }

void Link::breakOff(const Error& error) { closed(error); }

void Link::connect() {
  socket_ = std::make_unique<LiveSocket>(
      io_, address_, target_, options_,
      LiveSocket::Handlers{[this] { opened(); },
                           [this](std::span<const std::uint8_t> bytes) {
                             if (!closing_) handlers_.message(bytes);
                           },
                           [this](const Error& error) { closed(error); }});
}

void Link::after(std::chrono::milliseconds wait, std::function<void()> what) {
  const std::uint64_t round = ++round_;
  timer_.expires_after(wait);
  timer_.async_wait([this, round, what = std::move(what)](error_code cancelled) {
    if (!cancelled && round == round_) what();
  });
}

void Link::forgetTimer() {
  ++round_;  // it may have gone off already
  timer_.cancel();
}

void Link::opened() {
  if (closing_) return;
  const auto limit = options_.timeouts.connect;
  after(limit, [this, limit] {
    closed({ErrorCode::kUnavailable,
            toString(address_) + ": no reply within " + std::to_string(limit.count()) + " ms"});
  });
  handlers_.opened();
}

void Link::closed(const Error& error) {
  socket_.reset();
  forgetTimer();
  if (closing_) return finish();
  const auto wait = handlers_.lost(error);
  if (!wait) return finish();
  if (!closing_) after(*wait, [this] { connect(); });
}

/// Stops, whatever timers still run.
void Link::finish() {
  closing_ = true;
  socket_.reset();
  handlers_.ended();
  io_.stop();
}

}  // namespace culld::client
