#include "client/sdk/dial.h"

#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <vector>

namespace culld::client {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;
using Endpoint = asio::generic::stream_protocol::endpoint;

constexpr std::size_t kLongestUnixPath = 107;  // sun_path of Linux, less the final zero

std::vector<Endpoint> endpointsOf(asio::io_context& io, const Address& address,
                                  error_code& failed) {
  std::vector<Endpoint> endpoints;
  if (address.unixSocket()) {
    if (address.path.size() > kLongestUnixPath) {
      failed = asio::error::name_too_long;
    } else {
      endpoints.emplace_back(asio::local::stream_protocol::endpoint(address.path));
    }
    return endpoints;
  }
  tcp::resolver resolver(io);
  for (const auto& found : resolver.resolve(address.host, std::to_string(address.port), failed)) {
    endpoints.emplace_back(found.endpoint());
  }
  return endpoints;
}

error_code connectWithin(asio::io_context& io, Socket& socket, const Endpoint& endpoint,
                         std::chrono::milliseconds timeout) {
  error_code result = asio::error::timed_out;
  socket.async_connect(endpoint, [&result](error_code ec) {
    if (ec != asio::error::operation_aborted) result = ec;
  });
  io.restart();
  io.run_for(timeout);
  if (!io.stopped()) {
    error_code ignored;
    socket.close(ignored);
    io.run();
  }
  return result;
}

}  // namespace

protocol::Result<Socket> dial(asio::io_context& io, const Address& address,
                              std::chrono::milliseconds timeout) {
  error_code failed;
  for (const Endpoint& endpoint : endpointsOf(io, address, failed)) {
    Socket socket(io);
    failed = connectWithin(io, socket, endpoint, timeout);
    if (failed) continue;
    if (!address.unixSocket()) {
      error_code ignored;
      socket.set_option(tcp::no_delay(true), ignored);
    }
    return socket;
  }
  return protocol::Error{protocol::ErrorCode::kUnavailable,
                         toString(address) + ": cannot connect: " + failed.message()};
}

std::string hostHeader(const Address& address) {
  return address.unixSocket() ? "localhost" : toString(address).substr(5);  // without "ws://"
}

std::string percentEncoded(std::string_view text) {
  constexpr std::string_view kPlain =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-._~";
  constexpr std::string_view kHex = "0123456789ABCDEF";
  std::string out;
  for (const char c : text) {
    if (kPlain.find(c) != std::string_view::npos) {
      out += c;
    } else {
      const auto byte = static_cast<unsigned char>(c);
      out += {'%', kHex[byte >> 4U], kHex[byte & 15U]};
    }
  }
  return out;
}

}  // namespace culld::client
