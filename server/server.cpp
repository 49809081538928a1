#include "server/server.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <deque>
#include <future>
#include <sstream>
#include <thread>

#include "server/acceptor.h"
#include "server/build_info.h"
#include "server/context.h"

namespace culld::server {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using asio::local::stream_protocol;
using boost::system::error_code;

/// One can wait for the disk while another prepares a method for an edit.
constexpr std::size_t kEditThreads = 2;

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
  Impl(ServerOptions given, std::unique_ptr<SceneFiles> files,
       std::unique_ptr<EditFolder> edit_folder, std::unique_ptr<Access> let_in,
       std::unique_ptr<TlsKeys> keys)
      : options(std::move(given)),
        access(std::move(let_in)),
        tls(std::move(keys)),
        store(std::move(files), std::move(edit_folder), options.methods, options.limits.max_scenes,
              options.load),
        context{options.limits,
                serverName(),
                steadyClock(),
                store,
                metrics,
                options.log ? *options.log : silent,
                *access,
                tls.get(),
                workers,
                loaders,
                edits,
                [this](std::function<void()> task) { asio::post(io, std::move(task)); },
                steadyClock().now(),
                {},
                0},
        workers(options.threads, steadyClock()),
        loaders(1, steadyClock()),
        edits(kEditThreads) {
    if (tls != nullptr) metrics.certificateExpires(tls->expires());
  }

  ~Impl() {
    io.stop();
    if (io_thread.joinable()) io_thread.join();
    removeSocketFile();
  }

  Result<void> listen() {
    if (!options.inherited.empty()) return adopt();
    if (auto r = listenTcp(); !r || options.unix_path.empty()) return r;
    return listenUnix();
  }

  Result<void> adopt() {
    for (const InheritedSocket& socket : options.inherited) {
      const bool local = socket.family == AF_UNIX;
      auto adopted = local ? unix_acceptors.emplace_back(io, context).adopt(socket)
                           : tcp_acceptors.emplace_back(io, context).adopt(socket);
      if (!adopted) return adopted;
    }
    return Done{};
  }

  Result<void> listenTcp() {
    error_code failure;
    const auto address = asio::ip::make_address(options.listen_host, failure);
    const std::string where = options.listen_host + ":" + std::to_string(options.listen_port);
    if (failure) {
      return invalidInput(where + ": " + options.listen_host + " is not an IP address");
    }
    return tcp_acceptors.emplace_back(io, context).listen({address, options.listen_port}, where);
  }

  Result<void> listenUnix() {
    if (options.unix_path.size() >= sizeof(sockaddr_un::sun_path)) {
      return invalidInput(options.unix_path + ": path too long for a socket");
    }
    removeStaleSocket(options.unix_path, io);
    const mode_t before = ::umask(0117);  // the socket is for its owner and group from the start
    auto listening =
        unix_acceptors.emplace_back(io, context).listen({options.unix_path}, options.unix_path);
    ::umask(before);
    if (listening) owns_socket_file = true;
    return listening;
  }

  /// Of what is bound, whoever bound it.
  Result<void> exposure(const AccessOptions& rules, const TlsOptions& keys) const {
    for (const auto& acceptor : tcp_acceptors) {
      const std::string host = acceptor.localEndpoint().address().to_string();
      if (auto safe = checkExposure(host, rules, keys); !safe) return safe;
    }
    return Done{};
  }

  /// One that was handed over is its maker's.
  void removeSocketFile() {
    if (std::exchange(owns_socket_file, false)) ::unlink(options.unix_path.c_str());
  }

  void accept() {
    for (auto& acceptor : tcp_acceptors) {
      std::ostringstream text;
      text << acceptor.localEndpoint();  // HOST:PORT, with brackets around IPv6
      addresses.push_back(text.str());
      if (port == 0) port = acceptor.localEndpoint().port();
      acceptor.accept();
    }
    for (auto& acceptor : unix_acceptors) {
      addresses.push_back(acceptor.localEndpoint().path());
      acceptor.accept();
    }
  }

  void stopAccepting() {
    removeSocketFile();
    for (auto& acceptor : tcp_acceptors) acceptor.close();
    for (auto& acceptor : unix_acceptors) acceptor.close();
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
  std::unique_ptr<Access> access;
  std::unique_ptr<TlsKeys> tls;
  Metrics metrics;
  Log silent;
  SceneStore store;
  Context context;
  asio::io_context io{1};
  asio::executor_work_guard<asio::io_context::executor_type> work = asio::make_work_guard(io);
  asio::steady_timer drain_timer{io};
  std::deque<Acceptor<tcp>> tcp_acceptors;
  std::deque<Acceptor<stream_protocol>> unix_acceptors;
  bool owns_socket_file = false;
  std::uint16_t port = 0;
  std::vector<std::string> addresses;
  WorkerPool workers;
  WorkerPool loaders;
  EditQueue edits;
  std::thread io_thread;
};

Server::Server(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Server::~Server() = default;

Result<std::unique_ptr<Server>> Server::start(ServerOptions options) {
  auto files = SceneFiles::open(options.data_folder);
  if (!files) return files.error();
  std::unique_ptr<EditFolder> edits;
  if (!files.value()->temporary()) {
    auto kept = EditFolder::open(files.value()->folder() / "edits", files.value()->serials());
    if (!kept) return kept.error();
    edits = std::move(kept).value();
  }
  auto access = Access::open(options.access);
  if (!access) return access.error();
  std::unique_ptr<TlsKeys> tls;
  if (options.tls.enabled()) {
    auto keys = TlsKeys::open(options.tls);
    if (!keys) return keys.error();
    tls = std::move(keys).value();
  }
  auto impl = std::make_unique<Impl>(std::move(options), std::move(files).value(), std::move(edits),
                                     std::move(access).value(), std::move(tls));
  if (auto listening = impl->listen(); !listening) return listening.error();
  if (auto safe = impl->exposure(impl->options.access, impl->options.tls); !safe) {
    return safe.error();
  }
  impl->accept();
  impl->io_thread = std::thread([io = &impl->io] { io->run(); });
  return std::unique_ptr<Server>(new Server(std::move(impl)));
}

std::uint16_t Server::port() const noexcept { return impl_->port; }

const std::vector<std::string>& Server::addresses() const noexcept { return impl_->addresses; }

void Server::setLimits(const ServerLimits& limits) {
  asio::post(impl_->io, [impl = impl_.get(), limits] { impl->context.limits = limits; });
}

void Server::whenAlive(std::function<void()> task) { asio::post(impl_->io, std::move(task)); }

void Server::configRead(bool good) { impl_->metrics.configRead(good); }

Result<std::vector<std::string>> Server::loadScenes() {
  SceneStore& store = impl_->store;
  std::set<std::string> given;
  for (const auto& [name, path] : impl_->options.scene_files) given.insert(name);
  auto lines = store.loadAll(given);
  if (!lines) return lines;
  for (const auto& [name, path] : impl_->options.scene_files) {
    auto added = store.addFile(name, path);
    if (!added) return added.error();
    if (added.value()) lines.value().push_back(*added.value());
  }
  impl_->metrics.scenesHeld(store.names(), store.damaged().size());
  impl_->context.ready = true;
  return lines;
}

Result<void> Server::reloadAccess(const AccessOptions& access, const TlsOptions& tls) {
  Impl& impl = *impl_;
  if (tls.enabled() != (impl.tls != nullptr)) {
    return Error{ErrorCode::kUnsupported, "tls: can be switched on and off by a restart only"};
  }
  // All is read before anything is changed.
  if (auto r = impl.exposure(access, tls); !r) return r;
  std::unique_ptr<TlsKeys> keys;
  if (tls.enabled()) {
    auto opened = TlsKeys::open(tls);
    if (!opened) return opened.error();
    keys = std::move(opened).value();
  }
  if (auto r = impl.access->reload(access); !r) return r;
  if (keys != nullptr) {
    impl.tls->take(std::move(*keys));
    impl.metrics.certificateExpires(impl.tls->expires());
  }
  asio::post(impl.io, [&context = impl.context] { context.accessChanged(); });
  return Done{};
}

void Server::drain() {
  auto idle = std::make_shared<std::promise<void>>();
  auto finished = idle->get_future();
  impl_->context.draining = true;
  asio::post(impl_->io, [impl = impl_.get(), idle] {
    impl->stopAccepting();
    impl->context.goAway(nullptr, "the server is shutting down");
    const auto until = impl->context.clock.now() + impl->context.limits.drain_timeout;
    impl->awaitIdle(until, [idle] { idle->set_value(); });
  });
  finished.wait();
}

void Server::removeTemporaryFiles() { impl_->store.removeTemporaryFiles(); }

}  // namespace culld::server
