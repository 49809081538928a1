// The bytes of one client: a socket of either family, plain or under TLS, as one kind of stream, so
// that HTTP and WebSocket are written and compiled once. Beast's timeouts are those of the socket.
#pragma once
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core/basic_stream.hpp>
#include <boost/beast/ssl/ssl_stream.hpp>
#include <boost/beast/websocket/teardown.hpp>
#include <memory>
#include <utility>
#include <variant>

namespace culld::server {

class ClientStream {
 public:
  using PlainStream = boost::beast::basic_stream<boost::asio::generic::stream_protocol>;
  using TlsStream = boost::beast::ssl_stream<PlainStream>;
  using executor_type = PlainStream::executor_type;
  using next_layer_type = PlainStream;
  using ErrorCode = boost::beast::error_code;

  /// Plain if there is no `tls`.
  ClientStream(PlainStream::socket_type socket,
               const std::shared_ptr<boost::asio::ssl::context>& tls)
      : stream_(std::in_place_type<PlainStream>, std::move(socket)) {
    if (tls == nullptr) return;
    PlainStream plain = std::move(*std::get_if<PlainStream>(&stream_));
    stream_.emplace<TlsStream>(std::move(plain), *tls);
  }

  executor_type get_executor() { return next_layer().get_executor(); }
  /// The socket and its timeouts, below any TLS.
  PlainStream& next_layer() {
    TlsStream* tls = std::get_if<TlsStream>(&stream_);
    return tls != nullptr ? tls->next_layer() : *std::get_if<PlainStream>(&stream_);
  }
  const PlainStream& next_layer() const { return const_cast<ClientStream*>(this)->next_layer(); }
  bool tls() const noexcept { return std::holds_alternative<TlsStream>(stream_); }

  template <typename Buffers, typename Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    visit([&](auto& stream) { stream.async_read_some(buffers, std::forward<Handler>(handler)); });
  }
  template <typename Buffers, typename Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    visit([&](auto& stream) { stream.async_write_some(buffers, std::forward<Handler>(handler)); });
  }

  /// Agrees on keys; of a plain stream nothing is asked. `handler` takes an ErrorCode.
  template <typename Handler>
  void handshake(Handler&& handler) {
    if (TlsStream* tls = std::get_if<TlsStream>(&stream_)) {
      return tls->async_handshake(TlsStream::server, std::forward<Handler>(handler));
    }
    std::forward<Handler>(handler)(ErrorCode());
  }

  /// Tells the peer that nothing more will come. What it says to that does not matter: it may be
  /// gone. `handler` takes nothing; the socket may then still be read.
  template <typename Handler>
  void endWriting(Handler&& handler) {
    const auto shut = [this] {
      ErrorCode ignored;  // the peer may be gone already
      next_layer().socket().shutdown(boost::asio::socket_base::shutdown_send, ignored);
    };
    TlsStream* tls = std::get_if<TlsStream>(&stream_);
    if (tls != nullptr) {
      return tls->async_shutdown(
          [shut, handler = std::forward<Handler>(handler)](ErrorCode) mutable {
            shut();
            handler();
          });
    }
    shut();
    std::forward<Handler>(handler)();
  }

 private:
  template <typename Visitor>
  void visit(Visitor&& visitor) {
    if (TlsStream* tls = std::get_if<TlsStream>(&stream_)) return visitor(*tls);
    visitor(*std::get_if<PlainStream>(&stream_));
  }

  std::variant<PlainStream, TlsStream> stream_;
};

/// How a WebSocket ends the stream below it.
template <typename Handler>
void async_teardown(boost::beast::role_type role, ClientStream& stream, Handler&& handler) {
  using boost::beast::websocket::async_teardown;
  if (!stream.tls()) {
    return async_teardown(role, stream.next_layer(), std::forward<Handler>(handler));
  }
  stream.next_layer().expires_after(std::chrono::seconds(2));
  stream.endWriting([&stream, handler = std::forward<Handler>(handler)]() mutable {
    stream.next_layer().close();
    handler(boost::beast::error_code());
  });
}

}  // namespace culld::server
