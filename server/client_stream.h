// The bytes of one client: a socket of either family, plain or under TLS, as one kind of stream, so
// that HTTP and WebSocket are written and compiled once. Beast's timeouts are those of the socket.
#pragma once
#include <array>
#include <boost/asio/any_completion_handler.hpp>
#include <boost/asio/buffer.hpp>
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

  /// `handler` takes an ErrorCode and a std::size_t. What it is made of ends here: TLS and sockets
  /// are compiled once, in client_stream.cpp, not again for every operation of HTTP and WebSocket.
  template <typename Buffers, typename Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    readSome(fewOf<boost::asio::mutable_buffer>(buffers), std::forward<Handler>(handler));
  }
  template <typename Buffers, typename Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    writeSome(fewOf<boost::asio::const_buffer>(buffers), std::forward<Handler>(handler));
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
  using Transferred = boost::asio::any_completion_handler<void(ErrorCode, std::size_t)>;
  /// As many buffers as a call takes at once, the unused ones empty.
  template <typename Buffer>
  using FewBuffers = std::array<Buffer, 8>;

  /// The first of `buffers` that are not empty: "some" may always be less than all.
  template <typename Buffer, typename Buffers>
  static FewBuffers<Buffer> fewOf(const Buffers& buffers) {
    FewBuffers<Buffer> few;
    std::size_t used = 0;
    const auto end = boost::asio::buffer_sequence_end(buffers);
    for (auto at = boost::asio::buffer_sequence_begin(buffers); at != end && used < few.size();
         ++at) {
      const Buffer buffer = *at;
      if (buffer.size() > 0) few[used++] = buffer;
    }
    return few;
  }

  void readSome(const FewBuffers<boost::asio::mutable_buffer>& buffers, Transferred handler);
  void writeSome(const FewBuffers<boost::asio::const_buffer>& buffers, Transferred handler);

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
