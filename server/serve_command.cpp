#include "server/serve_command.h"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <thread>

#include "culling/core/simd.h"
#include "server/access.h"
#include "server/backend_option.h"
#include "server/server.h"

namespace culld {
namespace {

constexpr int kLoaded = SIGUSR1;  ///< how the loading thread wakes the one that waits for signals

void drawProgress(std::size_t done, std::size_t total) {
  constexpr std::size_t kWidth = 40;
  const std::size_t filled = total == 0 ? kWidth : done * kWidth / total;
  const std::string bar = std::string(filled, '#') + std::string(kWidth - filled, '.');
  std::fprintf(stderr, "\rloading [%s] %3zu %%%s", bar.c_str(),
               total == 0 ? 100 : done * 100 / total, done >= total ? "\r\x1b[K" : "");
}

sigset_t watchedSignals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  sigaddset(&set, SIGHUP);
  sigaddset(&set, kLoaded);
  return set;
}

/// Raises the limit of open files, as Debian's soft one of 1024 is below the documented number of
/// connections, and fits that number to it: were descriptors to run out, connections could not even
/// be refused. A connection has a socket, and the file of its upload.
server::ServerLimits fittedToDescriptors(server::ServerLimits limits, server::Log& log) {
  constexpr rlim_t kReserve = 64;  // scenes being read, listening sockets, the log
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return limits;
  limit.rlim_cur = limit.rlim_max;
  if (::setrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return limits;
  const rlim_t most = limit.rlim_cur > kReserve + 2 ? (limit.rlim_cur - kReserve) / 2 : rlim_t{1};
  if (most >= limits.max_connections) return limits;
  limits.max_connections = static_cast<std::size_t>(most);
  log.warning("fewer connections, as this process may have few files open",
              {{"max_connections", most}, {"open_files", limit.rlim_cur}});
  return limits;
}

ExitCode exitCodeOf(ErrorCode code, const server::Config& config) {
  switch (code) {
    case ErrorCode::kIo:
      return kDisk;
    case ErrorCode::kInvalidInput:
      return mistakeIn(config);
    default:
      return kUnavailable;
  }
}

std::string joined(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : ", ") + word;
  return out;
}

/// A server between its start and its end: signals, what systemd is told, new configurations.
class Daemon {
 public:
  Daemon(const ServeArguments& arguments, server::Config config, server::Server& server,
         server::Log& log, const server::ServiceManager& manager, const sigset_t& signals)
      : arguments_(arguments),
        started_with_(std::move(config)),
        server_(server),
        log_(log),
        manager_(manager),
        signals_(signals) {}

  /// REQUIRES: the watched signals are blocked in all threads.
  int run() {
    manager_.tell("STATUS=loading scenes");
    std::optional<Result<std::vector<std::string>>> loaded;  // read after the thread was joined
    const pthread_t waiter = pthread_self();
    std::thread loader([this, &loaded, waiter] {
      loaded = server_.loadScenes();
      pthread_kill(waiter, kLoaded);
    });
    if (awaitSignal() != kLoaded) leaveWhileLoading();
    loader.join();
    if (!loaded->ok()) return fail(kUsage, loaded->error().message);
    for (const std::string& line : loaded->value()) {
      log_.error("stored scene not served", {{"error", line}});
    }
    log_.info("ready");
    ready_ = true;
    tellReady();
    while (awaitSignal() == kLoaded) {
    }
    drain();
    return kFine;
  }

 private:
  /// The next signal but SIGHUP, which is seen to here. A watchdog is told meanwhile that the
  /// server's own thread turns over.
  int awaitSignal() {
    const auto interval = manager_.watchdogInterval();
    for (;;) {
      int signal = 0;
      if (interval.count() == 0) {
        if (sigwait(&signals_, &signal) != 0) continue;
      } else {
        const timespec time{interval.count() / 1'000'000, interval.count() % 1'000'000 * 1000};
        signal = sigtimedwait(&signals_, nullptr, &time);
        if (signal < 0) server_.whenAlive([&manager = manager_] { manager.tell("WATCHDOG=1"); });
      }
      if (signal == SIGHUP) reload();
      if (signal > 0 && signal != SIGHUP) return signal;
    }
  }

  void tellReady() const {
    if (!ready_) return;
    manager_.tell("READY=1\nSTATUS=serving on " + joined(server_.addresses()));
  }

  void reload() {
    if (ready_) manager_.tellReloading();
    ExitCode unused = kFine;
    auto config = readConfig(arguments_, unused);
    if (config) {
      auto access = server_.reloadAccess(config.value().access, config.value().tls);
      if (!access) config = access.error();
    }
    if (config) {
      take(config.value());
    } else {
      log_.error("configuration refused, the old one stays", {{"error", config.error().message}});
    }
    server_.configRead(config.ok());
    tellReady();
  }

  void take(const server::Config& config) {
    const auto later = server::changedForRestart(started_with_, config);
    log_.set(config.log);
    server_.setLimits(fittedToDescriptors(config.limits, log_));
    log_.info("configuration read");
    if (!later.empty()) {
      log_.warning("changed, but taken up at the next start only", {{"keys", joined(later)}});
    }
  }

  void drain() {
    log_.info("draining");
    manager_.tell("STOPPING=1\nSTATUS=draining");
    std::thread([signals = signals_] {  // a second signal: at once
      int signal = kLoaded;
      while (signal == kLoaded || signal == SIGHUP) {
        if (sigwait(&signals, &signal) != 0) signal = kLoaded;
      }
      std::_Exit(128 + signal);
    })
        .detach();
    server_.drain();
    log_.info("done");
  }

  /// The loader cannot be called off, and may have a minute to go: its thread ends with the
  /// process.
  [[noreturn]] void leaveWhileLoading() {
    drain();
    server_.removeTemporaryFiles();
    std::_Exit(kFine);
  }

  const ServeArguments& arguments_;
  const server::Config started_with_;
  server::Server& server_;
  server::Log& log_;
  const server::ServiceManager& manager_;
  const sigset_t signals_;
  bool ready_ = false;
};

server::ServerOptions optionsOf(const server::Config& config) {
  server::ServerOptions options;
  // The configuration was checked: its address is one.
  const auto address = server::parseListen(config.listen).value();
  options.listen_host = address.host;
  options.listen_port = address.port;
  options.unix_path = config.unix_path;
  options.data_folder = config.data_folder;
  options.scene_files.assign(config.scenes.begin(), config.scenes.end());
  options.threads = config.threads;
  options.methods = allMethods();
  options.access = config.access;
  options.tls = config.tls;
  if (::isatty(STDERR_FILENO) != 0) options.load.progress = drawProgress;
  return options;
}

}  // namespace

int runServe(const ServeArguments& arguments) {
  ExitCode code = kFine;
  auto config = readConfig(arguments, code);
  if (!config) return fail(code, config.error().message);
  if (auto forced = forceSimdTarget(config.value().simd); !forced) {
    return fail(mistakeIn(config.value()), forced.error().message);
  }
  if (auto opened = openBackendNamed(config.value().backend); !opened) {
    return fail(exitCodeOf(opened.error().code, config.value()), opened.error().message);
  }
  // A file that the configuration names and that cannot be used is its mistake.
  if (auto usable = server::checkAccess(config.value().access, config.value().tls); !usable) {
    return fail(kConfig, usable.error().message);
  }
  const auto log = server::Log::toStderr();
  log->set(config.value().log);
  auto options = optionsOf(config.value());
  options.limits = fittedToDescriptors(config.value().limits, *log);
  options.log = log.get();
  if (config.value().backend != "auto" && config.value().backend != "cpu") {
    log->info("drawing with " + backendInUse());
  }
  auto inherited = server::inheritedSockets();
  if (!inherited) return fail(kConfig, inherited.error().message);
  options.inherited = std::move(inherited).value();
  // Of what others bind the server asks the sockets.
  if (auto safe = checkListen(config.value()); options.inherited.empty() && !safe) {
    return fail(kConfig, safe.error().message);
  }
  const server::ServiceManager manager;

  std::signal(SIGPIPE, SIG_IGN);  // a reader of our log that goes away must not end the daemon
  const sigset_t signals = watchedSignals();
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  auto server = server::Server::start(std::move(options));
  if (!server) {
    return fail(exitCodeOf(server.error().code, config.value()), server.error().message);
  }
  for (const std::string& address : server.value()->addresses()) {
    log->info("listening on " + address);
  }
  return Daemon(arguments, std::move(config).value(), *server.value(), *log, manager, signals)
      .run();
}

}  // namespace culld
