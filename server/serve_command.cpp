#include "server/serve_command.h"

#include <pthread.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <thread>

#include "server/command_line.h"
#include "server/scene_files.h"
#include "server/server.h"

namespace culld {
namespace {

constexpr int kLoaded = SIGUSR1;  ///< how the loading thread wakes the one that waits for signals

/// "HOST:PORT", "[::1]:PORT".
Result<void> parseListen(const std::string& text, server::ServerOptions& options) {
  const auto colon = text.rfind(':');
  const auto wrong = invalidInput("--listen " + text + ": not HOST:PORT");
  if (colon == std::string::npos || colon == 0) return wrong;
  const char* end = text.data() + text.size();
  const auto [stop, failure] = std::from_chars(text.data() + colon + 1, end, options.listen_port);
  if (failure != std::errc() || stop != end) return wrong;
  options.listen_host = text.substr(0, colon);
  if (options.listen_host.size() > 2 && options.listen_host.front() == '[' &&
      options.listen_host.back() == ']') {
    options.listen_host = options.listen_host.substr(1, options.listen_host.size() - 2);
  }
  if (options.listen_host == "localhost") options.listen_host = "127.0.0.1";
  return Done{};
}

Result<void> parseScenes(const std::vector<std::string>& scenes, server::ServerOptions& options) {
  for (const std::string& scene : scenes) {
    const auto equals = scene.find('=');
    if (equals == std::string::npos || equals == 0 || equals + 1 == scene.size()) {
      return invalidInput("--scene " + scene + ": not NAME=FILE");
    }
    const std::string name = scene.substr(0, equals);
    if (!server::validSceneName(name)) {
      return invalidInput("--scene " + scene + ": name is not [A-Za-z0-9._-]{1,64}");
    }
    const auto same = [&name](const auto& earlier) { return earlier.first == name; };
    if (std::any_of(options.scene_files.begin(), options.scene_files.end(), same)) {
      return invalidInput("--scene " + scene + ": the name " + name + " is given twice");
    }
    options.scene_files.emplace_back(name, scene.substr(equals + 1));
  }
  return Done{};
}

void drawProgress(std::size_t done, std::size_t total) {
  constexpr std::size_t kWidth = 40;
  const std::size_t filled = total == 0 ? kWidth : done * kWidth / total;
  const std::string bar = std::string(filled, '#') + std::string(kWidth - filled, '.');
  std::fprintf(stderr, "\rloading [%s] %3zu %%%s", bar.c_str(),
               total == 0 ? 100 : done * 100 / total, done >= total ? "\r\x1b[K" : "");
}

/// What the loading thread leaves behind; read after it was joined.
struct Loading {
  std::optional<Result<std::vector<std::string>>> result;
};

sigset_t watchedSignals() {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGTERM);
  sigaddset(&set, SIGINT);
  sigaddset(&set, kLoaded);
  return set;
}

int awaitSignal(const sigset_t& set) {
  int signal = 0;
  while (sigwait(&set, &signal) != 0) {
  }
  return signal;
}

void drain(server::Server& server, server::Log& log, const sigset_t& set) {
  log.info("draining");
  std::thread([set] {  // a second signal: at once
    int signal = kLoaded;
    while (signal == kLoaded) signal = awaitSignal(set);
    std::_Exit(128 + signal);
  })
      .detach();
  server.drain();
  log.info("done");
}

/// The loader cannot be called off, and may have a minute to go: its thread ends with the process.
[[noreturn]] void leaveWhileLoading(server::Server& server, server::Log& log, const sigset_t& set) {
  drain(server, log, set);
  server.removeTemporaryFiles();
  std::_Exit(kFine);
}

/// REQUIRES: the watched signals are blocked in all threads.
int serveUntilSignal(server::Server& server, server::Log& log, const sigset_t& set) {
  Loading loading;
  const pthread_t waiter = pthread_self();
  std::thread loader([&server, &loading, waiter] {
    loading.result = server.loadScenes();
    pthread_kill(waiter, kLoaded);
  });
  if (awaitSignal(set) != kLoaded) leaveWhileLoading(server, log, set);
  loader.join();
  if (!loading.result->ok()) return fail(kUsage, loading.result->error().message);
  for (const std::string& line : loading.result->value()) {
    log.error("stored scene not served", {{"error", line}});
  }
  log.info("ready");
  while (awaitSignal(set) == kLoaded) {
  }
  drain(server, log, set);
  return kFine;
}

/// Raises the limit of open files, as Debian's soft one of 1024 is below the documented number of
/// connections, and fits that number to it: were descriptors to run out, connections could not even
/// be refused. A connection has a socket, and the file of its upload.
void fitConnectionsToDescriptors(server::ServerLimits& limits, server::Log& log) {
  constexpr rlim_t kReserve = 64;  // scenes being read, listening sockets, the log
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  if (::setrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return;
  const rlim_t most = limit.rlim_cur > kReserve + 2 ? (limit.rlim_cur - kReserve) / 2 : rlim_t{1};
  if (most >= limits.max_connections) return;
  limits.max_connections = static_cast<std::size_t>(most);
  log.warning("fewer connections, as this process may have few files open",
              {{"max_connections", most}, {"open_files", limit.rlim_cur}});
}

ExitCode exitCodeOf(ErrorCode code) {
  switch (code) {
    case ErrorCode::kIo:
      return kDisk;
    case ErrorCode::kInvalidInput:
      return kUsage;
    default:
      return kUnavailable;
  }
}

}  // namespace

int runServe(const ServeArguments& arguments) {
  const auto log = server::Log::toStderr();
  server::ServerOptions options;
  if (auto r = parseListen(arguments.listen, options); !r) {
    return fail(kUsage, r.error().message);
  }
  if (auto r = parseScenes(arguments.scenes, options); !r) {
    return fail(kUsage, r.error().message);
  }
  options.unix_path = arguments.unix_path;
  options.data_folder = arguments.data_folder;
  options.threads = arguments.threads;
  options.methods = allMethods();
  if (::isatty(STDERR_FILENO) != 0) options.load.progress = drawProgress;

  std::signal(SIGPIPE, SIG_IGN);  // a reader of our log that goes away must not end the daemon
  fitConnectionsToDescriptors(options.limits, *log);
  options.log = log.get();
  const sigset_t set = watchedSignals();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  auto server = server::Server::start(std::move(options));
  if (!server) return fail(exitCodeOf(server.error().code), server.error().message);
  for (const std::string& address : server.value()->addresses()) {
    log->info("listening on " + address);
  }
  return serveUntilSignal(*server.value(), *log, set);
}

}  // namespace culld
