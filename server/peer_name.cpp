// Whom a socket leads to, for the log.
#include <sys/socket.h>

#include <boost/asio/ip/tcp.hpp>
#include <cstring>
#include <sstream>

#include "server/connections.h"

namespace culld::server {

std::string peerName(const StreamSocket& socket) {
  boost::system::error_code failure;
  const auto peer = socket.remote_endpoint(failure);
  if (failure) return "gone";
  const int family = peer.protocol().family();
  boost::asio::ip::tcp::endpoint address;
  if ((family != AF_INET && family != AF_INET6) || peer.size() > address.capacity()) return "unix";
  std::memcpy(address.data(), peer.data(), peer.size());
  std::ostringstream text;
  text << address;
  return text.str();
}

}  // namespace culld::server
