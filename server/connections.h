// The two kinds of connection, made from a fresh socket of either family (TCP or Unix).
#pragma once
#include <boost/asio/generic/stream_protocol.hpp>
#include <string>

#include "server/context.h"

namespace culld::server {

using StreamSocket = boost::asio::generic::stream_protocol::socket;

/// "192.0.2.1:51234", "unix", or "gone".
std::string peerName(const StreamSocket& socket);

/// Speaks HTTP/1.1 until the connection ends or becomes a live one. Owns itself.
/// REQUIRES: the I/O thread; `context` outlives all connections.
void serveHttp(StreamSocket socket, AddressTicket ticket, Context& context);

/// Speaks WebSocket for one scene. `request` is the upgrade's header as it was received and what
/// followed it.
void serveLive(StreamSocket socket, std::string request, std::shared_ptr<Scene> scene,
               AddressTicket ticket, Context& context);

}  // namespace culld::server
