#include "server/server.h"

#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <future>
#include <thread>

#include "server/build_info.h"
#include "server/connections.h"
#include "server/context.h"

namespace culld::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::local::stream_protocol;
using boost::system::error_code;

Error cannotBind(const std::string& where, const error_code& failure) {
  return {ErrorCode::kUnavailable, where + ": cannot listen: " + failure.message()};
}

/// Accepts for ever; each socket of either family is served as the same kind of stream.
template <typename Protocol>
class Acceptor {
 public:
  Acceptor(asio::io_context& io, Context& context) : acceptor_(io), retry_(io), context_(context) {}

  Result<void> listen(const typename Protocol::endpoint& endpoint, const std::string& where) {
    error_code failure;
    acceptor_.open(endpoint.protocol(), failure);
    if (!failure) acceptor_.set_option(asio::socket_base::reuse_address(true), failure);
    if (!failure) acceptor_.bind(endpoint, failure);
    if (!failure) acceptor_.listen(asio::socket_base::max_listen_connections, failure);
    if (!failure) return Done{};
    close();  // an open acceptor owns its socket file
    return cannotBind(where, failure);
  }

  void accept() {
    acceptor_.async_accept([this](error_code failure, typename Protocol::socket socket) {
      if (failure == asio::error::operation_aborted) return;
      if (failure) return acceptLater();  // out of descriptors, say: the next may work
      serve(std::move(socket));
      accept();
    });
  }

  void close() {
    error_code ignored;  // nothing is left to be done about it
    acceptor_.close(ignored);
    retry_.cancel();
  }

  auto localEndpoint() const { return acceptor_.local_endpoint(); }
  bool open() const { return acceptor_.is_open(); }

 private:
  void acceptLater() {
    retry_.expires_after(std::chrono::milliseconds(50));
    retry_.async_wait([this](error_code failure) {
      if (!failure) accept();
    });
  }

  void serve(typename Protocol::socket socket) {
    if (context_.metrics.totals().connections >=
        static_cast<double>(context_.limits.max_connections)) {
      context_.metrics.connectionRefused();
      return refuse(std::move(socket), context_.limits.max_connections);
    }
    if constexpr (std::is_same_v<Protocol, tcp>) {
      error_code ignored;  // a socket that is gone already fails at its first read
      socket.set_option(tcp::no_delay(true), ignored);
    }
    serveHttp(StreamSocket(std::move(socket)), context_);
  }

  static void refuse(typename Protocol::socket socket, std::size_t limit) {
    const std::string body = "{\"error\":\"too many connections: " + std::to_string(limit) +
                             " are open, and no more are taken\"}\n";
    const std::string reply =
        "HTTP/1.1 503 Service Unavailable\r\nRetry-After: 1\r\nConnection: close\r\n"
        "Content-Type: application/json\r\nContent-Length: " +
        std::to_string(body.size()) + "\r\n\r\n" + body;
    error_code ignored;  // a courtesy: who is not reading gets a closed socket
    socket.non_blocking(true, ignored);
    socket.write_some(asio::buffer(reply), ignored);
  }

  typename Protocol::acceptor acceptor_;
  asio::steady_timer retry_;
  Context& context_;
};

/// A socket file that nobody answers on is left over from a process that was killed.
void removeStaleSocket(const std::string& path, asio::io_context& io) {
  struct stat info {};
  if (::lstat(path.c_str(), &info) != 0 || !S_ISSOCK(info.st_mode)) return;
  stream_protocol::socket probe(io);
  error_code failure;
  probe.connect(stream_protocol::endpoint(path), failure);
  if (failure) ::unlink(path.c_str());
}

}  // namespace

struct Server::Impl {
  Impl(ServerOptions given, std::unique_ptr<SceneFiles> files)
      : options(std::move(given)),
        store(std::move(files), options.methods, options.limits.max_scenes, options.load),
        context{options.limits,
                serverName(),
                steadyClock(),
                store,
                metrics,
                workers,
                loaders,
                [this](std::function<void()> task) { asio::post(io, std::move(task)); },
                steadyClock().now(),
                {},
                0},
        tcp_acceptor(io, context),
        unix_acceptor(io, context),
        workers(options.threads),
        loaders(1) {}

  ~Impl() {
    io.stop();
    if (io_thread.joinable()) io_thread.join();
    if (unix_acceptor.open()) ::unlink(options.unix_path.c_str());
  }

  Result<void> listen() {
    error_code failure;
    const auto address = asio::ip::make_address(options.listen_host, failure);
    const std::string where = options.listen_host + ":" + std::to_string(options.listen_port);
    if (failure) {
      return invalidInput(where + ": " + options.listen_host + " is not an IP address");
    }
    if (auto r = tcp_acceptor.listen({address, options.listen_port}, where); !r) return r;
    port = tcp_acceptor.localEndpoint().port();
    if (options.unix_path.empty()) return Done{};
    if (options.unix_path.size() >= sizeof(sockaddr_un::sun_path)) {
      return invalidInput(options.unix_path + ": path too long for a socket");
    }
    removeStaleSocket(options.unix_path, io);
    const mode_t before = ::umask(0117);  // the socket is for its owner and group from the start
    auto listening = unix_acceptor.listen({options.unix_path}, options.unix_path);
    ::umask(before);
    return listening;
  }

  void stopAccepting() {
    tcp_acceptor.close();
    if (unix_acceptor.open()) ::unlink(options.unix_path.c_str());
    unix_acceptor.close();
  }

  /// Calls `done` on the I/O thread once nothing is in flight, or time is up.
  void awaitIdle(std::chrono::nanoseconds until, std::function<void()> done) {
    if ((context.live.empty() && context.busy_requests == 0) || context.clock.now() >= until) {
      return done();
    }
    drain_timer.expires_after(std::chrono::milliseconds(5));
    drain_timer.async_wait([this, until, done = std::move(done)](error_code failure) {
      if (!failure) awaitIdle(until, done);
    });
  }

  // Order matters: connections live in the queues of `io` and of the pools, and use the rest.
  ServerOptions options;
  Metrics metrics;
  SceneStore store;
  Context context;
  asio::io_context io{1};
  asio::executor_work_guard<asio::io_context::executor_type> work = asio::make_work_guard(io);
  asio::steady_timer drain_timer{io};
  Acceptor<tcp> tcp_acceptor;
  Acceptor<stream_protocol> unix_acceptor;
  WorkerPool workers;
  WorkerPool loaders;
  std::uint16_t port = 0;
  std::thread io_thread;
};

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() = default;

Result<std::unique_ptr<Server>> Server::start(ServerOptions options) {
  auto files = SceneFiles::open(options.data_folder);
  if (!files) return files.error();
  auto impl = std::make_unique<Impl>(std::move(options), std::move(files).value());
  if (auto listening = impl->listen(); !listening) return listening.error();
  impl->tcp_acceptor.accept();
  if (impl->unix_acceptor.open()) impl->unix_acceptor.accept();
  impl->io_thread = std::thread([io = &impl->io] { io->run(); });
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

std::uint16_t Server::port() const noexcept { return impl_->port; }

Result<std::vector<std::string>> Server::loadScenes() {
  auto failures = impl_->store.loadAll();
  for (const auto& [name, path] : impl_->options.scene_files) {
    if (auto added = impl_->store.addFile(name, path); !added) return added.error();
  }
  impl_->metrics.scenesHeld(impl_->store.names());
  impl_->context.ready = true;
  return failures;
}

void Server::drain() {
  auto idle = std::make_shared<std::promise<void>>();
  auto finished = idle->get_future();
  impl_->context.draining = true;
  asio::post(impl_->io, [impl = impl_.get(), idle] {
    impl->stopAccepting();
    impl->context.goAway(nullptr, "the server is shutting down");
    const auto until = impl->context.clock.now() + impl->options.limits.drain_timeout;
    impl->awaitIdle(until, [idle] { idle->set_value(); });
  });
  finished.wait();
}

void Server::removeTemporaryFiles() { impl_->store.removeTemporaryFiles(); }

}  // namespace culld::server
