// Connects a socket, TCP or Unix, within a time limit. Both kinds are one type from here on.
#pragma once
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include "culld/address.h"
#include "protocol/result.h"

namespace culld::client {

using Socket = boost::asio::generic::stream_protocol::socket;

/// Tries every address that the host's name has; looking the name up and each of them may take
/// `timeout`. Calls `done` once, on `io`, unless `io` is stopped first. REQUIRES: `socket` lives
/// until then. ERROR: kUnavailable "ws://127.0.0.1:7420: cannot connect: Connection refused".
void dial(boost::asio::io_context& io, Socket& socket, const Address& address,
          std::chrono::milliseconds timeout,
          std::function<void(std::optional<protocol::Error>)> done);

/// The Host header of requests to `address`.
std::string hostHeader(const Address& address);
/// Everything but letters, digits and "-._~" as %XX.
std::string percentEncoded(std::string_view text);

}  // namespace culld::client
