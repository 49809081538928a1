// One WebSocket to a scene: whole messages in, whole messages out. live_socket.cpp is one of the
// two files of this room that see Beast.
#pragma once
#include <boost/asio/io_context.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "culld/connection.h"

namespace culld::client {

/// THREADS: only that of `io`, which also calls the handlers. Destroying it, in a handler too, cuts
/// the connection, and no handler is called any more.
class LiveSocket {
 public:
  struct Handlers {
    std::function<void()> opened;
    std::function<void(std::span<const std::uint8_t>)> message;
    std::function<void(const Error&)> closed;  ///< once, as the last
  };

  /// Begins to connect and to upgrade at `target`.
  LiveSocket(boost::asio::io_context& io, const Address& address, const std::string& target,
             const ConnectOptions& options, Handlers handlers);
  ~LiveSocket();
  LiveSocket(const LiveSocket&) = delete;
  LiveSocket& operator=(const LiveSocket&) = delete;

  void send(std::vector<std::uint8_t> bytes);
  /// Says goodbye; `closed` follows, if the server answers.
  void close();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace culld::client
