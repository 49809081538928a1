// Bytes to and from a server: a socket, with TLS around it if the address says so. One type for
// both, so that what is built on it is compiled once. Seen by http.cpp and live_socket.cpp only.
#pragma once
#include <boost/asio/async_result.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "client/sdk/dial.h"
#include "culld/options.h"

namespace culld::client {

class Stream {
 public:
  using executor_type = Socket::executor_type;
  using TlsContext = boost::asio::ssl::context;

  explicit Stream(boost::asio::io_context& io) : io_(io), socket_(io) {}

  /// Connects, and makes sure of the server if `tls` is given. Each step may take `timeout`. Calls
  /// `done` once unless `io` is stopped first. REQUIRES: this lives until then.
  /// ERROR: kUnavailable; TLS: "wss://HOST:PORT: TLS: certificate verify failed".
  void connect(const Address& address, std::shared_ptr<TlsContext> tls,
               std::chrono::milliseconds timeout,
               std::function<void(std::optional<protocol::Error>)> done);

  Socket& next_layer() noexcept { return socket_; }
  executor_type get_executor() { return socket_.get_executor(); }

  template <typename Buffers, typename Token>
  auto async_read_some(const Buffers& buffers, Token&& token) {
    return boost::asio::async_initiate<Token, void(boost::system::error_code, std::size_t)>(
        [this](auto handler, const Buffers& to) {
          if (tls_) {
            tls_->async_read_some(to, std::move(handler));
          } else {
            socket_.async_read_some(to, std::move(handler));
          }
        },
        token, buffers);
  }

  template <typename Buffers, typename Token>
  auto async_write_some(const Buffers& buffers, Token&& token) {
    return boost::asio::async_initiate<Token, void(boost::system::error_code, std::size_t)>(
        [this](auto handler, const Buffers& from) {
          if (tls_) {
            tls_->async_write_some(from, std::move(handler));
          } else {
            socket_.async_write_some(from, std::move(handler));
          }
        },
        token, buffers);
  }

 private:
  void secure(const Address& address, std::chrono::milliseconds timeout,
              std::function<void(std::optional<protocol::Error>)> done);

  boost::asio::io_context& io_;
  Socket socket_;
  std::shared_ptr<TlsContext> context_;
  std::optional<boost::asio::ssl::stream<Socket&>> tls_;
};

/// What `access` trusts, for wss:// addresses; null for others.
/// ERROR: kInvalidInput: the token cannot be sent; "FILE: no certificates: ...".
protocol::Result<std::shared_ptr<Stream::TlsContext>> trustOf(const Address& address,
                                                              const Access& access);

}  // namespace culld::client
