#include "client/sdk/live_socket.h"

#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <optional>
#include <utility>

#include "client/sdk/refusal.h"
#include "client/sdk/stream.h"
#include "protocol/limits.h"
#include "protocol/version.h"

namespace culld::client {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using beast::error_code;

/// How a WebSocket ends on a Stream: its own closing frames have said all, so TLS adds nothing.
template <typename Handler>
void async_teardown(beast::role_type role, Stream& stream, Handler&& handler) {
  websocket::async_teardown(role, stream.next_layer(), std::forward<Handler>(handler));
}

struct LiveSocket::Impl : std::enable_shared_from_this<LiveSocket::Impl> {
  Impl(asio::io_context& context, const Address& where, Handlers h)
      : address(where), handlers(std::move(h)), io(context), ws(context) {}

  void connect(const std::string& target, const ConnectOptions& options) {
    auto trust = trustOf(address, options.access);
    if (!trust) {
      return asio::post(
          io, [self = shared_from_this(), error = std::move(trust).error()] { self->end(error); });
    }
    configure(options);
    ws.next_layer().connect(address, std::move(trust).value(), options.timeouts.connect,
                            [self = shared_from_this(), target](std::optional<Error> failed) {
                              if (failed) return self->end(*failed);
                              self->upgrade(target);
                            });
  }

  void configure(const ConnectOptions& options) {
    websocket::stream_base::timeout limits{};
    limits.handshake_timeout = options.timeouts.connect;
    limits.idle_timeout = options.timeouts.idle;
    limits.keep_alive_pings = true;
    ws.set_option(limits);
    ws.set_option(websocket::stream_base::decorator(
        [token = options.access.token](websocket::request_type& request) {
          request.set(http::field::sec_websocket_protocol, protocol::kSubprotocol);
          if (!token.empty()) request.set(http::field::authorization, "Bearer " + token);
        }));
    ws.binary(true);
    ws.auto_fragment(false);
    ws.read_message_max(protocol::kMaxReplyBytes);
  }

  void upgrade(const std::string& target) {
    if (ended) return;
    ws.async_handshake(reply, hostHeader(address), target,
                       [self = shared_from_this()](error_code ec) { self->upgraded(ec); });
  }

  void upgraded(error_code ec) {
    if (ec == websocket::error::upgrade_declined) {
      return end(refusal(address, reply.result_int(), reply.body()));
    }
    if (ec) {
      return end({ErrorCode::kUnavailable, toString(address) + ": cannot open: " + ec.message()});
    }
    if (reply[http::field::sec_websocket_protocol] != protocol::kSubprotocol) {
      return end({ErrorCode::kUnsupported, toString(address) + ": the server does not speak " +
                                               std::string(protocol::kSubprotocol)});
    }
    if (ended) return;
    handlers.opened();
    if (!ended) read();
  }

  void read() {
    ws.async_read(in, [self = shared_from_this()](error_code ec, std::size_t) {
      if (ec) return self->lost(ec);
      if (self->ended) return;
      const auto bytes = self->in.cdata();
      self->handlers.message({static_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
      self->in.clear();
      if (!self->ended) self->read();
    });
  }

  void push(std::vector<std::uint8_t> bytes) {
    if (ended) return;
    out.push_back(std::move(bytes));
    if (out.size() == 1) write();
  }

  void write() {
    ws.async_write(asio::buffer(out.front()),
                   [self = shared_from_this()](error_code ec, std::size_t) {
                     if (ec) return self->lost(ec);
                     self->out.pop_front();
                     if (!self->out.empty()) self->write();
                   });
  }

  void close() {
    if (ended || !ws.is_open()) return lost(asio::error::operation_aborted);
    ws.async_close(websocket::close_code::normal, [self = shared_from_this()](error_code ec) {
      self->lost(ec ? ec : websocket::error::closed);
    });
  }

  void lost(error_code ec) {
    end({ErrorCode::kUnavailable, toString(address) + ": connection lost: " + ec.message()});
  }

  void end(const Error& why) {
    if (ended) return;
    cut();
    handlers.closed(why);
  }

  void cut() {
    ended = true;
    error_code ignored;
    ws.next_layer().next_layer().close(ignored);
  }

  const Address address;
  const Handlers handlers;
  asio::io_context& io;
  websocket::stream<Stream> ws;
  http::response<http::string_body> reply;
  beast::flat_buffer in;
  std::deque<std::vector<std::uint8_t>> out;  ///< the front one is on its way
  bool ended = false;
};

LiveSocket::LiveSocket(asio::io_context& io, const Address& address, const std::string& target,
                       const ConnectOptions& options, Handlers handlers)
    : impl_(std::make_shared<Impl>(io, address, std::move(handlers))) {
  impl_->connect(target, options);
}

LiveSocket::~LiveSocket() { impl_->cut(); }

void LiveSocket::send(std::vector<std::uint8_t> bytes) { impl_->push(std::move(bytes)); }

void LiveSocket::close() { impl_->close(); }

}  // namespace culld::client
