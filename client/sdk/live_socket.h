// One WebSocket to a scene: whole messages in, whole messages out, on a thread of its own.
// live_socket.cpp is one of the two files of this room that see Beast.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "culld/connection.h"

namespace culld::client {

class LiveSocket {
 public:
  /// Both are called on the socket's thread; `closed` once, as the last.
  struct Handlers {
    std::function<void(std::span<const std::uint8_t>)> message;
    std::function<void(const Error&)> closed;
  };

  /// Connects and upgrades; nothing is read before start().
  static Result<std::unique_ptr<LiveSocket>> connect(const Address& address,
                                                     const std::string& target,
                                                     const Timeouts& timeouts);
  /// Closes, and waits for the thread. REQUIRES: not called from a handler.
  ~LiveSocket();

  void start(Handlers handlers);
  /// COST: returns at once. After the end of the connection it does nothing. THREADS: any.
  void send(std::vector<std::uint8_t> bytes);

 private:
  struct Impl;
  explicit LiveSocket(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace culld::client
