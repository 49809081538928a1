#include "culld/address.h"

#include <charconv>

namespace culld::client {
namespace {

constexpr std::string_view kTcp = "ws://", kTls = "wss://", kUnix = "unix:";

/// "host:port" or "[v6]:port".
bool splitHostPort(std::string_view text, Address& address) {
  const auto colon = text.rfind(':');
  if (colon == std::string_view::npos) return false;
  std::string_view host = text.substr(0, colon);
  if (host.size() > 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return false;
  }
  const std::string_view port = text.substr(colon + 1);
  const auto read = std::from_chars(port.data(), port.data() + port.size(), address.port);
  address.host = host;
  return !host.empty() && host.find_first_of("/[] ") == std::string_view::npos &&
         read.ec == std::errc{} && read.ptr == port.data() + port.size() && address.port != 0;
}

}  // namespace

protocol::Result<Address> parseAddress(std::string_view text) {
  Address address;
  if (text.substr(0, kUnix.size()) == kUnix && text.size() > kUnix.size()) {
    address.path = text.substr(kUnix.size());
    return address;
  }
  for (const std::string_view scheme : {kTcp, kTls}) {
    if (text.substr(0, scheme.size()) != scheme) continue;
    address.tls = scheme == kTls;
    std::string_view rest = text.substr(scheme.size());
    if (!rest.empty() && rest.back() == '/') rest.remove_suffix(1);
    if (splitHostPort(rest, address)) return address;
  }
  return protocol::invalidInput(std::string(text) +
                                ": not an address like ws://127.0.0.1:7420 or unix:PATH");
}

std::string toString(const Address& address) {
  if (address.unixSocket()) return std::string(kUnix) + address.path;
  const bool v6 = address.host.find(':') != std::string::npos;
  return std::string(address.tls ? kTls : kTcp) + (v6 ? "[" + address.host + "]" : address.host) +
         ":" + std::to_string(address.port);
}

}  // namespace culld::client
