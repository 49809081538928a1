#include "client/sdk/http.h"

#include <boost/beast/core/file.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <optional>

#include "client/sdk/stream.h"

namespace culld::client {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
using beast::error_code;
using Verb = http::verb;

constexpr std::uint64_t kMaxBodyBytes = std::uint64_t{1} << 30;  // 8 bytes for each of 16e6 objects

class Exchange {
 public:
  std::optional<Error> connect(const Address& address, std::shared_ptr<Stream::TlsContext> tls,
                               std::chrono::milliseconds timeout) {
    std::optional<Error> failed;
    stream_.connect(address, std::move(tls), timeout,
                    [&failed](std::optional<Error> error) { failed = std::move(error); });
    io_.run();
    return failed;
  }

  /// Sends what `serializer` has, bit by bit; each bit may take `timeout`.
  template <typename Serializer>
  error_code send(Serializer& serializer, std::chrono::milliseconds timeout,
                  const std::function<void()>& sent_more) {
    error_code failed;
    while (!failed && !serializer.is_done()) {
      http::async_write_some(stream_, serializer,
                             [&failed](error_code ec, std::size_t) { failed = ec; });
      if (!runFor(timeout)) failed = asio::error::timed_out;
      sent_more();
    }
    return failed;
  }

  error_code receive(http::response_parser<http::string_body>& parser,
                     std::chrono::milliseconds first_byte, std::chrono::milliseconds silence) {
    error_code failed;
    auto patience = first_byte;
    while (!failed && !parser.is_done()) {
      http::async_read_some(stream_, buffer_, parser,
                            [&failed](error_code ec, std::size_t) { failed = ec; });
      if (!runFor(patience)) failed = asio::error::timed_out;
      patience = silence;
    }
    return failed;
  }

 private:
  /// False if what was begun was not done in time; then it is cut off.
  bool runFor(std::chrono::milliseconds time) {
    io_.restart();
    io_.run_for(time);
    if (io_.stopped()) return true;
    error_code ignored;
    stream_.next_layer().close(ignored);
    io_.run();
    return false;
  }

  asio::io_context io_{1};
  Stream stream_{io_};
  beast::flat_buffer buffer_;
};

Error fileError(const std::string& path, error_code ec) {
  return {ErrorCode::kIo, path + ": cannot read: " + ec.message()};
}

template <typename Body>
http::request<Body> requestFor(const Address& address, const HttpRequest& what,
                               const Access& access) {
  http::request<Body> request(http::string_to_verb(what.verb), what.target, 11);
  request.set(http::field::host, hostHeader(address));
  request.set(http::field::connection, "close");
  request.set(http::field::accept, "application/json");
  if (!access.token.empty()) request.set(http::field::authorization, "Bearer " + access.token);
  return request;
}

/// Sends the file; what goes wrong on the wire is left for the reply to explain.
error_code sendFile(Exchange& exchange, const Address& address, const HttpRequest& what,
                    const Access& access, http::file_body::value_type file,
                    const HttpTimeouts& timeouts) {
  auto request = requestFor<http::file_body>(address, what, access);
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
                     const Access& access, const HttpTimeouts& timeouts) {
  const auto request = requestFor<http::empty_body>(address, what, access);
  http::request_serializer<http::empty_body> serializer(request);
  return exchange.send(serializer, timeouts.exchange, [] {});
}

}  // namespace

Result<HttpReply> exchange(const Address& address, const HttpRequest& request, const Access& access,
                           const HttpTimeouts& timeouts) {
  http::file_body::value_type file;
  const bool has_file = !request.body_path.empty();
  if (has_file) {
    error_code ec;
    file.open(request.body_path.c_str(), beast::file_mode::scan, ec);
    if (ec) return fileError(request.body_path, ec);
  }
  auto trust = trustOf(address, access);
  if (!trust) return std::move(trust).error();
  Exchange exchange;
  auto failed = exchange.connect(address, std::move(trust).value(), timeouts.connect);
  if (failed) return *std::move(failed);

  error_code unsent;
  if (has_file) {
    unsent = sendFile(exchange, address, request, access, std::move(file), timeouts);
  } else {
    unsent = sendPlain(exchange, address, request, access, timeouts);
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
