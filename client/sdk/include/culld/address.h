// Where a culld server listens.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "protocol/result.h"

namespace culld::client {

struct Address {
  std::string host;        ///< of TCP; empty for a Unix socket
  std::uint16_t port = 0;  ///< of TCP
  std::string path;        ///< of a Unix socket
  bool tls = false;        ///< wss://
  bool unixSocket() const noexcept { return !path.empty(); }
};

/// "ws://host:port", "wss://host:port" (TLS), "ws://[::1]:7420" or "unix:PATH".
/// ERROR: `localhost: not an address like ws://127.0.0.1:7420 or unix:PATH`.
protocol::Result<Address> parseAddress(std::string_view text);

/// The way back: what parseAddress() reads.
std::string toString(const Address& address);

}  // namespace culld::client
