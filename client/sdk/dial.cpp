#include "client/sdk/dial.h"

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <memory>
#include <utility>
#include <vector>

namespace culld::client {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Endpoint = asio::generic::stream_protocol::endpoint;
using Finish = std::function<void(std::optional<protocol::Error>)>;

constexpr std::size_t kLongestUnixPath = 107;  // sun_path of Linux, less the final zero

/// One call of dial(); alive while one of its steps is under way.
class Dialer : public std::enable_shared_from_this<Dialer> {
 public:
  Dialer(asio::io_context& io, Socket& socket, const Address& address,
         std::chrono::milliseconds timeout, Finish done)
      : address_(address),
        timeout_(timeout),
        done_(std::move(done)),
        socket_(socket),
        resolver_(io),
        timer_(io) {}

  void start() {
    if (!address_.unixSocket()) return resolve();
    if (address_.path.size() > kLongestUnixPath) return finish(asio::error::name_too_long);
    endpoints_.emplace_back(asio::local::stream_protocol::endpoint(address_.path));
    tryNext(asio::error::not_found);
  }

 private:
  void resolve() {
    error_code no_number;
    const auto ip = asio::ip::make_address(address_.host, no_number);
    if (!no_number) {
      endpoints_.emplace_back(tcp::endpoint(ip, address_.port));
      return tryNext(asio::error::not_found);
    }
    limit([this] { resolver_.cancel(); });
    resolver_.async_resolve(
        address_.host, std::to_string(address_.port),
        [self = shared_from_this()](error_code ec, const tcp::resolver::results_type& found) {
          self->inTime();
          for (const auto& entry : found) self->endpoints_.emplace_back(entry.endpoint());
          self->tryNext(self->timed_out_ ? asio::error::timed_out : ec);
        });
  }

  /// `failed`: how the last one did.
  void tryNext(error_code failed) {
    if (next_ == endpoints_.size()) return finish(failed);
    error_code ignored;
    socket_.close(ignored);
    limit([this] {
      error_code none;
      socket_.close(none);
    });
    socket_.async_connect(endpoints_[next_++], [self = shared_from_this()](error_code ec) {
      self->inTime();
      if (self->timed_out_) ec = asio::error::timed_out;
      return ec ? self->tryNext(ec) : self->finish({});
    });
  }

  template <typename Cut>
  void limit(Cut cut) {
    timed_out_ = false;
    timer_.expires_after(timeout_);
    timer_.async_wait([self = shared_from_this(), cut, step = ++step_](error_code cancelled) {
      if (cancelled || step != self->step_) return;
      self->timed_out_ = true;
      cut();
    });
  }

  void inTime() {
    ++step_;  // the timer may have gone off already
    timer_.cancel();
  }

  void finish(error_code failed) {
    if (failed) {
      return done_(protocol::Error{protocol::ErrorCode::kUnavailable,
                                   toString(address_) + ": cannot connect: " + failed.message()});
    }
    error_code ignored;
    if (!address_.unixSocket()) socket_.set_option(tcp::no_delay(true), ignored);
    done_(std::nullopt);
  }

  const Address address_;
  const std::chrono::milliseconds timeout_;
  const Finish done_;
  Socket& socket_;
  tcp::resolver resolver_;
  asio::steady_timer timer_;
  std::vector<Endpoint> endpoints_;
  std::size_t next_ = 0;
  std::uint64_t step_ = 0;
  bool timed_out_ = false;
};

}  // namespace

void dial(asio::io_context& io, Socket& socket, const Address& address,
          std::chrono::milliseconds timeout, Finish done) {
  auto dialer = std::make_shared<Dialer>(io, socket, address, timeout, std::move(done));
  asio::post(io, [dialer] { dialer->start(); });
}

std::string hostHeader(const Address& address) {
  if (address.unixSocket()) return "localhost";
  const std::string text = toString(address);
  return text.substr(text.find("//") + 2);
}

std::string percentEncoded(std::string_view text) {
  constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string out;
  for (const char c : text) {
    if (kPlain.find(c) != std::string_view::npos) {
      out += c;
    } else {
      const auto byte = static_cast<unsigned char>(c);
      out += {'%', kHex[byte >> 4U], kHex[byte & 15U]};
    }
  }
  return out;
}

}  // namespace culld::client
