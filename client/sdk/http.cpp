#include "client/sdk/http.h"

#include <boost/beast/core/file.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http.hpp>
#include <optional>

#include "client/sdk/dial.h"

namespace culld::client {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using beast::error_code;
using Stream = beast::basic_stream<asio::generic::stream_protocol>;
using Verb = http::verb;

constexpr std::uint64_t kMaxBodyBytes = std::uint64_t{1} << 30;  // 8 bytes for each of 16e6 objects

class Exchange {
 public:
  Exchange(asio::io_context& io, Socket socket) : io_(io), stream_(std::move(socket)) {}

  /// Sends what `serializer` has, bit by bit; each bit may take `timeout`.
  template <typename Serializer>
  error_code send(Serializer& serializer, std::chrono::milliseconds timeout,
                  const std::function<void()>& sent_more) {
    error_code failed;
    while (!failed && !serializer.is_done()) {
      stream_.expires_after(timeout);
      http::async_write_some(stream_, serializer,
                             [&failed](error_code ec, std::size_t) { failed = ec; });
      run();
      sent_more();
    }
    return failed;
  }

  error_code receive(http::response_parser<http::string_body>& parser,
                     std::chrono::milliseconds first_byte, std::chrono::milliseconds silence) {
    error_code failed;
    stream_.expires_after(first_byte);
    while (!failed && !parser.is_done()) {
      http::async_read_some(stream_, buffer_, parser,
                            [&failed](error_code ec, std::size_t) { failed = ec; });
      run();
      stream_.expires_after(silence);
    }
    return failed;
  }

 private:
  void run() {
    io_.restart();
    io_.run();
  }

  asio::io_context& io_;
  Stream stream_;
  beast::flat_buffer buffer_;
};

Error fileError(const std::string& path, error_code ec) {
  return {ErrorCode::kIo, path + ": cannot read: " + ec.message()};
}

template <typename Body>
http::request<Body> requestFor(const Address& address, const HttpRequest& what) {
  http::request<Body> request(http::string_to_verb(what.verb), what.target, 11);
  request.set(http::field::host, hostHeader(address));
  request.set(http::field::connection, "close");
  request.set(http::field::accept, "application/json");
  return request;
}

/// Sends the file; what goes wrong on the wire is left for the reply to explain.
error_code sendFile(Exchange& exchange, const Address& address, const HttpRequest& what,
                    http::file_body::value_type file, const HttpTimeouts& timeouts) {
  auto request = requestFor<http::file_body>(address, what);
  request.set(http::field::content_type, "model/gltf-binary");
  const std::uint64_t total = file.size();
  request.body() = std::move(file);
  request.content_length(total);
  http::request_serializer<http::file_body> serializer(request);
  serializer.split(false);
  std::uint64_t reported = 0;
  return exchange.send(serializer, timeouts.exchange, [&] {
    error_code ignored;
    const std::uint64_t at = request.body().file().pos(ignored);
    if (what.progress && at != reported) what.progress(reported = at, total);
  });
}

error_code sendPlain(Exchange& exchange, const Address& address, const HttpRequest& what,
                     const HttpTimeouts& timeouts) {
  const auto request = requestFor<http::empty_body>(address, what);
  http::request_serializer<http::empty_body> serializer(request);
  return exchange.send(serializer, timeouts.exchange, [] {});
}

}  // namespace

Result<HttpReply> exchange(const Address& address, const HttpRequest& request,
                           const HttpTimeouts& timeouts) {
  http::file_body::value_type file;
  const bool has_file = !request.body_path.empty();
  if (has_file) {
    error_code ec;
    file.open(request.body_path.c_str(), beast::file_mode::scan, ec);
    if (ec) return fileError(request.body_path, ec);
  }
  asio::io_context io(1);
  auto socket = dial(io, address, timeouts.connect);
  if (!socket) return std::move(socket).error();
  Exchange exchange(io, std::move(socket).value());

  error_code unsent;
  if (has_file) {
    unsent = sendFile(exchange, address, request, std::move(file), timeouts);
  } else {
    unsent = sendPlain(exchange, address, request, timeouts);
  }
  // A server that refuses an upload answers before it has read it all.
  http::response_parser<http::string_body> parser;
  parser.body_limit(kMaxBodyBytes);
  const auto patience = has_file && !unsent ? timeouts.load : timeouts.exchange;
  const error_code unheard = exchange.receive(parser, patience, timeouts.exchange);
  if (unheard && unheard != http::error::end_of_stream) {
    const error_code first = unsent ? unsent : unheard;
    return Error{ErrorCode::kUnavailable, toString(address) + ": no answer: " + first.message()};
  }
  if (!parser.is_done()) {
    return Error{ErrorCode::kUnavailable, toString(address) + ": no answer: connection closed"};
  }
  return HttpReply{parser.get().result_int(), std::move(parser.get().body())};
}

}  // namespace culld::client
