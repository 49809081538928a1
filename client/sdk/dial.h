// Connects a socket, TCP or Unix, within a time limit. Both kinds are one type from here on.
#pragma once
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <chrono>

#include "culld/address.h"
#include "protocol/result.h"

namespace culld::client {

using Socket = boost::asio::generic::stream_protocol::socket;

/// Tries every address that the host's name has. REQUIRES: nothing else runs on `io`.
/// ERROR: kUnavailable "ws://127.0.0.1:7420: cannot connect: Connection refused".
protocol::Result<Socket> dial(boost::asio::io_context& io, const Address& address,
                              std::chrono::milliseconds timeout);

/// The Host header of requests to `address`.
std::string hostHeader(const Address& address);
/// Everything but letters, digits and "-._~" as %XX.
std::string percentEncoded(std::string_view text);

}  // namespace culld::client
