#include "client/sdk/live_socket.h"

#include <boost/asio/post.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/stream_traits.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket.hpp>
#include <deque>
#include <exception>
#include <optional>
#include <thread>
#include <utility>

#include "client/sdk/dial.h"
#include "client/sdk/refusal.h"
#include "protocol/limits.h"
#include "protocol/version.h"

namespace culld::client {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace websocket = beast::websocket;
using beast::error_code;
using Stream = websocket::stream<beast::basic_stream<asio::generic::stream_protocol>>;

Error upgradeError(const Address& address, error_code ec,
                   const http::response<http::string_body>& reply) {
  if (ec == websocket::error::upgrade_declined) {
    return refusal(address, reply.result_int(), reply.body());
  }
  return {ErrorCode::kUnavailable, toString(address) + ": cannot open: " + ec.message()};
}

}  // namespace

struct LiveSocket::Impl {
  Impl(std::unique_ptr<asio::io_context> context, Socket socket)
      : io(std::move(context)), ws(std::move(socket)) {}

  void read() {
    ws.async_read(in, [this](error_code ec, std::size_t) {
      if (ec) return end(ec);
      const auto bytes = in.cdata();
      handlers.message({static_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
      in.clear();
      if (!ended) read();
    });
  }

  void push(std::vector<std::uint8_t> bytes) {
    if (ended) return;
    out.push_back(std::move(bytes));
    if (out.size() == 1) write();
  }

  void write() {
    ws.async_write(asio::buffer(out.front()), [this](error_code ec, std::size_t) {
      if (ec) return end(ec);
      out.pop_front();
      if (!out.empty()) write();
    });
  }

  void end(error_code ec) {
    if (std::exchange(ended, true)) return;
    handlers.closed({ErrorCode::kUnavailable, "connection lost: " + ec.message()});
    error_code ignored;
    beast::get_lowest_layer(ws).socket().close(ignored);
    io->stop();  // Beast's idle timer would keep the thread until it fires
  }

  void close() {
    if (ended) return;
    ws.async_close(websocket::close_code::normal,
                   [this](error_code ec) { end(ec ? ec : websocket::error::closed); });
  }

  std::unique_ptr<asio::io_context> io;  ///< outlives the stream
  Stream ws;
  beast::flat_buffer in;
  std::deque<std::vector<std::uint8_t>> out;  ///< the front one is on its way
  Handlers handlers;
  bool ended = false;
  std::thread thread;
};

Result<std::unique_ptr<LiveSocket>> LiveSocket::connect(const Address& address,
                                                        const std::string& target,
                                                        const Timeouts& timeouts) {
  auto io = std::make_unique<asio::io_context>(1);
  auto socket = dial(*io, address, timeouts.connect);
  if (!socket) return std::move(socket).error();
  auto impl = std::make_unique<Impl>(std::move(io), std::move(socket).value());

  Stream& ws = impl->ws;
  websocket::stream_base::timeout limits{};
  limits.handshake_timeout = timeouts.connect;
  limits.idle_timeout = timeouts.idle;
  limits.keep_alive_pings = true;
  ws.set_option(limits);
  ws.set_option(websocket::stream_base::decorator([](websocket::request_type& request) {
    request.set(http::field::sec_websocket_protocol, protocol::kSubprotocol);
  }));
  ws.binary(true);
  ws.auto_fragment(false);
  ws.read_message_max(protocol::kMaxReplyBytes);

  http::response<http::string_body> reply;
  std::optional<error_code> done;
  ws.async_handshake(reply, hostHeader(address), target, [&done](error_code ec) { done = ec; });
  impl->io->restart();
  while (!done) impl->io->run_one();  // not run(): Beast's timer goes on after a refusal
  const error_code failed = *done;
  if (failed) return upgradeError(address, failed, reply);
  if (reply[http::field::sec_websocket_protocol] != protocol::kSubprotocol) {
    return Error{ErrorCode::kUnsupported, toString(address) + ": the server does not speak " +
                                              std::string(protocol::kSubprotocol)};
  }
  return std::unique_ptr<LiveSocket>(new LiveSocket(std::move(impl)));
}

LiveSocket::LiveSocket(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

LiveSocket::~LiveSocket() {
  if (!impl_->thread.joinable()) return;
  try {
    asio::post(*impl_->io, [impl = impl_.get()] { impl->close(); });
  } catch (const std::exception&) {  // out of memory: the server sees the connection break
    impl_->io->stop();
  }
  impl_->thread.join();
}

void LiveSocket::start(Handlers handlers) {
  impl_->handlers = std::move(handlers);
  impl_->io->restart();
  impl_->read();
  impl_->thread = std::thread([impl = impl_.get()] { impl->io->run(); });
}

void LiveSocket::send(std::vector<std::uint8_t> bytes) {
  asio::post(*impl_->io, [impl = impl_.get(), bytes = std::move(bytes)]() mutable {
    impl->push(std::move(bytes));
  });
}

}  // namespace culld::client
