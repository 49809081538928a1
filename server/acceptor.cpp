#include "server/acceptor.h"

#include <sys/socket.h>

#include <algorithm>

namespace culld::server {

namespace ip = boost::asio::ip;

Error cannotListen(const std::string& where, const boost::system::error_code& failure) {
  return {ErrorCode::kUnavailable, where + ": cannot listen: " + failure.message()};
}

Peer unixPeer(int descriptor) noexcept {
  ucred who{};
  socklen_t size = sizeof who;
  // A peer that the kernel cannot name is nobody.
  if (::getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &who, &size) != 0) {
    who.uid = static_cast<uid_t>(-1);
  }
  return {true, who.uid};
}

std::string sourceOf(const ip::address& address) {
  if (address.is_v4()) return address.to_string();
  const ip::address_v6 v6 = address.to_v6();
  if (v6.is_v4_mapped()) return ip::make_address_v4(ip::v4_mapped, v6).to_string();
  auto bytes = v6.to_bytes();
  std::fill(bytes.begin() + 8, bytes.end(), std::uint8_t{0});
  return ip::make_address_v6(bytes).to_string();
}

std::string refusalBytes(const std::string& status, const std::string& why) {
  const std::string body = "{\"error\":\"" + why + "\"}\n";
  return "HTTP/1.1 " + status +
         "\r\nConnection: close\r\nContent-Type: application/json\r\nContent-Length: " +
         std::to_string(body.size()) + "\r\n\r\n" + body;
}

}  // namespace culld::server
