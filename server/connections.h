// The two kinds of connection, made from a fresh socket of either family (TCP or Unix).
#pragma once
#include <boost/asio/generic/stream_protocol.hpp>
#include <string>

#include "server/context.h"

namespace culld::server {

using StreamSocket = boost::asio::generic::stream_protocol::socket;
class ClientStream;

/// "192.0.2.1:51234", "unix", or "gone".
std::string peerName(const StreamSocket& socket);

/// Who is at the other end.
struct Caller {
  Peer peer;
  AddressTicket place;  ///< among the connections of its address
  std::string name;     ///< peerName()
};

/// Speaks HTTP/1.1, on TCP under TLS if the server has keys for it, until the connection ends or
/// becomes a live one. Owns itself. REQUIRES: the I/O thread; `context` outlives all connections.
void serveHttp(StreamSocket socket, Caller caller, Context& context);

/// What an upgrade asks for.
struct LiveRequest {
  std::string bytes;  ///< its header as it was received, and what followed it
  std::shared_ptr<Scene> scene;
  Caller caller;
  Grant grant;
};

/// Speaks WebSocket for one scene.
void serveLive(ClientStream stream, LiveRequest request, Context& context);

}  // namespace culld::server
