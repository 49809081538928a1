#include "client/sdk/stream.h"

#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ssl/host_name_verification.hpp>
#include <boost/asio/steady_timer.hpp>
#include <string>

namespace culld::client {
namespace {

namespace asio = boost::asio;
namespace ssl = asio::ssl;
using boost::system::error_code;
using protocol::Error;
using protocol::ErrorCode;

/// Visible ASCII only: the token becomes a line of a header.
bool canBeSent(const std::string& token) {
  return std::all_of(token.begin(), token.end(), [](char c) { return c > ' ' && c < '\x7f'; });
}

}  // namespace

void Stream::connect(const Address& address, std::shared_ptr<TlsContext> tls,
                     std::chrono::milliseconds timeout,
                     std::function<void(std::optional<Error>)> done) {
  context_ = std::move(tls);
  dial(io_, socket_, address, timeout,
       [this, address, timeout, done = std::move(done)](std::optional<Error> failed) mutable {
         if (failed || !context_) return done(std::move(failed));
         secure(address, timeout, std::move(done));
       });
}

void Stream::secure(const Address& address, std::chrono::milliseconds timeout,
                    std::function<void(std::optional<Error>)> done) {
  tls_.emplace(socket_, *context_);
  tls_->set_verify_callback(ssl::host_name_verification(address.host));
  error_code no_number;
  asio::ip::make_address(address.host, no_number);
  // A server of many names is told which is meant; RFC 6066 has no numbers there.
  if (no_number) {  // SSL_set_tlsext_host_name(), whose macro holds an old-style cast
    std::string host = address.host;
    SSL_ctrl(tls_->native_handle(), SSL_CTRL_SET_TLSEXT_HOSTNAME, TLSEXT_NAMETYPE_host_name,
             host.data());
  }

  struct Limit {
    asio::steady_timer timer;
    bool passed = false, reached = false;
  };
  auto limit = std::make_shared<Limit>(Limit{asio::steady_timer(io_, timeout)});
  limit->timer.async_wait([this, limit](error_code cancelled) {
    if (cancelled || limit->reached) return;
    limit->passed = true;
    error_code ignored;
    socket_.close(ignored);
  });
  tls_->async_handshake(ssl::stream_base::client, [limit, address, done](error_code ec) {
    limit->reached = true;
    limit->timer.cancel();
    if (limit->passed) ec = asio::error::timed_out;
    if (!ec) return done(std::nullopt);
    done(Error{ErrorCode::kUnavailable, toString(address) + ": TLS: " + ec.message()});
  });
}

protocol::Result<std::shared_ptr<Stream::TlsContext>> trustOf(const Address& address,
                                                              const Access& access) {
  if (!canBeSent(access.token)) {
    return protocol::invalidInput("token: holds a space or a character that is not ASCII");
  }
  if (!address.tls) return std::shared_ptr<Stream::TlsContext>();
  auto context = std::make_shared<Stream::TlsContext>(ssl::context::tls_client);
  error_code ec;
  context->set_options(
      ssl::context::default_workarounds | ssl::context::no_tlsv1 | ssl::context::no_tlsv1_1, ec);
  context->set_verify_mode(ssl::verify_peer, ec);
  if (access.ca_file.empty()) {
    context->set_default_verify_paths(ec);
  } else {
    context->load_verify_file(access.ca_file, ec);
  }
  if (ec) return protocol::invalidInput(access.ca_file + ": no certificates: " + ec.message());
  return context;
}

}  // namespace culld::client
