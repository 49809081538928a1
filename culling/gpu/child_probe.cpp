#include "culling/gpu/child_probe.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <exception>
#include <string>
#include <thread>

#include "culling/core/clock.h"
#include "culling/gpu/unavailable.h"

namespace culld::gpu {
namespace {

constexpr std::chrono::seconds kUntilKilled{2};
constexpr char kFine = '+';  ///< anything else is the message of an error

[[noreturn]] void runChild(const std::function<Result<void>()>& attempt, int out) {
  const int nowhere = ::open("/dev/null", O_WRONLY | O_CLOEXEC);
  if (nowhere >= 0) ::dup2(nowhere, STDERR_FILENO);  // drivers talk
  std::string message(1, kFine);
  try {
    const auto done = attempt();
    if (!done) message = done.error().message;
  } catch (const std::exception& failure) {
    message = failure.what();
  }
  const char* rest = message.data();
  for (std::size_t left = message.size(); left > 0;) {
    const ssize_t written = ::write(out, rest, left);
    if (written <= 0) break;
    rest += written;
    left -= static_cast<std::size_t>(written);
  }
  ::_exit(0);  // no destructors: they would be the driver's
}

using Time = std::chrono::nanoseconds;

/// All that the child writes until it ends. False: it was not done in time.
bool readUntilEnd(int in, Time end, std::string& text) {
  for (;;) {
    const auto left =
        std::chrono::duration_cast<std::chrono::milliseconds>(end - steadyClock().now());
    if (left.count() <= 0) return false;
    pollfd waiting{in, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, static_cast<int>(left.count()));
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    std::array<char, 512> part{};
    const ssize_t got = ::read(in, part.data(), part.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return true;
    text.append(part.data(), static_cast<std::size_t>(got));
  }
}

/// False: it has not ended in time. Inside a driver not even SIGKILL ends a process for certain;
/// one that stays is the init process's when this one ends.
bool waitUntilEnd(pid_t child, Time end, int& status) {
  for (;;) {
    const pid_t ended = ::waitpid(child, &status, WNOHANG);
    if (ended == child) return true;
    if ((ended < 0 && errno != EINTR) || steadyClock().now() >= end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
}

}  // namespace

Result<void> tryInChild(const std::function<Result<void>()>& attempt,
                        std::chrono::milliseconds limit) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return unavailable("no pipe for a probe");
  const pid_t child = ::fork();
  if (child < 0) {
    ::close(ends[0]);
    ::close(ends[1]);
    return unavailable(std::string("no process for a probe: ") + std::strerror(errno));
  }
  if (child == 0) {
    ::close(ends[0]);
    runChild(attempt, ends[1]);
  }
  ::close(ends[1]);
  std::string text;
  int status = 0;
  const Time end = steadyClock().now() + limit;
  const bool ended = readUntilEnd(ends[0], end, text) && waitUntilEnd(child, end, status);
  ::close(ends[0]);
  if (!ended) {
    ::kill(child, SIGKILL);
    waitUntilEnd(child, steadyClock().now() + kUntilKilled, status);
    return unavailable("not done within " + std::to_string(limit.count()) + " ms");
  }
  if (WIFSIGNALED(status)) {
    return unavailable("its probe crashed with signal " + std::to_string(WTERMSIG(status)));
  }
  if (text.empty()) return unavailable("its probe ended without a word");
  if (text != std::string(1, kFine)) return unavailable(text);
  return Done{};
}

}  // namespace culld::gpu
