// Takes connections from one listening socket, of either family, and turns away those that are too
// many or not let in.
#pragma once
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/address.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <string>
#include <type_traits>
#include <utility>

#include "server/connections.h"
#include "server/context.h"
#include "server/systemd.h"

namespace culld::server {

Error cannotListen(const std::string& where, const boost::system::error_code& failure);
/// Who is at the other end of a Unix socket, as the kernel says.
Peer unixPeer(int descriptor) noexcept;
/// Whose connections are counted together: an IPv6 host commonly has all 2^64 addresses of its
/// network.
std::string sourceOf(const boost::asio::ip::address& address);
/// A whole HTTP reply. `status` may have headers at its end.
std::string refusalBytes(const std::string& status, const std::string& why);

/// Accepts for ever; each socket of either family is served as the same kind of stream.
template <typename Protocol>
class Acceptor {
 public:
  Acceptor(boost::asio::io_context& io, Context& context)
      : acceptor_(io), retry_(io), context_(context) {}

  Result<void> listen(const typename Protocol::endpoint& endpoint, const std::string& where) {
    boost::system::error_code failure;
    acceptor_.open(endpoint.protocol(), failure);
    if (!failure) acceptor_.set_option(boost::asio::socket_base::reuse_address(true), failure);
    if (!failure) acceptor_.bind(endpoint, failure);
    if (!failure) acceptor_.listen(boost::asio::socket_base::max_listen_connections, failure);
    if (!failure) return Done{};
    close();  // an open acceptor owns its socket file
    return cannotListen(where, failure);
  }

  /// A socket that listens already.
  Result<void> adopt(const InheritedSocket& socket) {
    boost::system::error_code failure;
    if constexpr (!kUnix) {
      acceptor_.assign(socket.family == boost::asio::ip::tcp::v4().family()
                           ? boost::asio::ip::tcp::v4()
                           : boost::asio::ip::tcp::v6(),
                       socket.descriptor, failure);
    } else {
      acceptor_.assign(Protocol(), socket.descriptor, failure);
    }
    if (!failure) return Done{};
    return cannotListen("descriptor " + std::to_string(socket.descriptor), failure);
  }

  void accept() {
    acceptor_.async_accept(
        [this](boost::system::error_code failure, typename Protocol::socket socket) {
          if (failure == boost::asio::error::operation_aborted) return;
          if (failure) return acceptLater();  // out of descriptors, say: the next may work
          serve(std::move(socket));
          accept();
        });
  }

  void close() {
    boost::system::error_code ignored;  // nothing is left to be done about it
    acceptor_.close(ignored);
    retry_.cancel();
  }

  auto localEndpoint() const { return acceptor_.local_endpoint(); }

 private:
  void acceptLater() {
    retry_.expires_after(std::chrono::milliseconds(50));
    retry_.async_wait([this](boost::system::error_code failure) {
      if (!failure) accept();
    });
  }

  void serve(typename Protocol::socket socket) {
    const Peer peer = kUnix ? unixPeer(socket.native_handle()) : Peer{};
    if (!context_.access.mayConnect(peer)) {
      context_.metrics.authFailed("peer");
      context_.log.info("connection refused",
                        {{"why", "not among unix_users"}, {"user", peer.user}});
      return refuse(std::move(socket), "403 Forbidden",
                    "user " + std::to_string(peer.user) + " may not use this socket");
    }
    if (context_.metrics.totals().connections >=
        static_cast<double>(context_.limits.max_connections)) {
      return refuseMore(std::move(socket), context_.limits.max_connections, "");
    }
    AddressTicket ticket;
    if constexpr (!kUnix) {
      boost::system::error_code ignored;  // a socket that is gone already fails at its first read
      socket.set_option(boost::asio::ip::tcp::no_delay(true), ignored);
      const std::size_t limit = context_.limits.max_connections_per_address;
      ticket = context_.addresses.enter(sourceOf(socket.remote_endpoint(ignored).address()), limit);
      if (!ticket) return refuseMore(std::move(socket), limit, " from this address");
    }
    StreamSocket stream(std::move(socket));
    std::string name = peerName(stream);
    serveHttp(std::move(stream), {peer, std::move(ticket), std::move(name)}, context_);
  }

  void refuseMore(typename Protocol::socket socket, std::size_t limit, const std::string& whence) {
    context_.metrics.connectionRefused();
    context_.log.warning("connection refused",
                         {{"why", "too many connections" + whence}, {"limit", limit}});
    refuse(std::move(socket), "503 Service Unavailable\r\nRetry-After: 1",
           "too many connections" + whence + ": " + std::to_string(limit) +
               " are open, and no more are taken");
  }

  void refuse(typename Protocol::socket socket, const std::string& status, const std::string& why) {
    // Who speaks TLS could make nothing of it.
    if (!kUnix && context_.tls != nullptr) return;
    const std::string reply = refusalBytes(status, why);
    boost::system::error_code ignored;  // a courtesy: who is not reading gets a closed socket
    socket.non_blocking(true, ignored);
    socket.write_some(boost::asio::buffer(reply), ignored);
  }

  static constexpr bool kUnix = !std::is_same_v<Protocol, boost::asio::ip::tcp>;
  typename Protocol::acceptor acceptor_;
  boost::asio::steady_timer retry_;
  Context& context_;
};

}  // namespace culld::server
