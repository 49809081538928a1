// How a client reaches a server: what it shows, whom it trusts, how long it waits, and what it does
// when the way there breaks.
#pragma once
#include <chrono>
#include <cstdint>
#include <string>

namespace culld::client {

/// What the client shows, and whom it trusts.
struct Access {
  std::string token;    ///< bearer token; empty: none. Sent as it is: use wss:// or a Unix socket
  std::string ca_file;  ///< PEM, for wss://: these authorities only; empty: those of the system
};

/// Of a live connection.
struct Timeouts {
  std::chrono::milliseconds connect{5'000};  ///< name, TCP, TLS, WebSocket, version: each
  std::chrono::milliseconds reply{30'000};   ///< for blocking calls
  std::chrono::milliseconds idle{60'000};    ///< silence, pings unanswered: the connection is lost
};

/// What happens when an open connection is lost. The n-th wait in a row is first * factor^(n-1), at
/// most `longest`, less a random share of it of up to `jitter`, so that the clients of a server
/// that comes back do not come all at once. The waits begin small again once a connection has held
/// for `longest`.
struct Reconnect {
  bool enabled = true;
  std::chrono::milliseconds first{100};
  std::chrono::milliseconds longest{10'000};
  double factor = 2.0;             ///< >= 1
  double jitter = 0.5;             ///< 0 to 1
  std::uint32_t max_attempts = 0;  ///< in a row; 0: for ever
};

struct ConnectOptions {
  Timeouts timeouts;
  Reconnect reconnect;
  Access access;
};

}  // namespace culld::client
