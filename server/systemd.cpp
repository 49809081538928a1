#include "server/systemd.h"

#include <fcntl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <optional>

namespace culld::server {
namespace {

constexpr int kFirstDescriptor = 3;
constexpr std::int64_t kMostDescriptors = 64;

std::optional<std::string> takeVariable(const char* name) {
  const char* value = std::getenv(name);
  if (value == nullptr) return std::nullopt;
  std::string taken = value;
  ::unsetenv(name);
  return taken;
}

std::optional<std::int64_t> number(const std::optional<std::string>& text) {
  std::int64_t value = 0;
  if (!text) return std::nullopt;
  const char* end = text->data() + text->size();
  const auto [stop, failure] = std::from_chars(text->data(), end, value);
  if (failure != std::errc() || stop != end) return std::nullopt;
  return value;
}

int socketOption(int descriptor, int option) {
  int value = -1;
  socklen_t size = sizeof value;
  return ::getsockopt(descriptor, SOL_SOCKET, option, &value, &size) == 0 ? value : -1;
}

}  // namespace

Result<std::vector<InheritedSocket>> inheritedSockets() {
  const auto meant_for = takeVariable("LISTEN_PID");
  const auto text = takeVariable("LISTEN_FDS");
  takeVariable("LISTEN_FDNAMES");
  std::vector<InheritedSocket> out;
  if (!text || !meant_for || number(meant_for) != ::getpid()) return out;
  const auto count = number(text);
  if (!count || *count < 0 || *count > kMostDescriptors) {
    return invalidInput("LISTEN_FDS: " + *text + " is not a number from 0 to " +
                        std::to_string(kMostDescriptors));
  }
  for (int fd = kFirstDescriptor; fd < kFirstDescriptor + *count; ++fd) {
    const int family = socketOption(fd, SO_DOMAIN);
    const bool known = family == AF_INET || family == AF_INET6 || family == AF_UNIX;
    if (!known || socketOption(fd, SO_TYPE) != SOCK_STREAM ||
        socketOption(fd, SO_ACCEPTCONN) != 1) {
      return invalidInput("LISTEN_FDS: descriptor " + std::to_string(fd) +
                          " is not a listening stream socket");
    }
    if (::fcntl(fd, F_SETFD, FD_CLOEXEC) != 0) {
      return Error{ErrorCode::kIo,
                   "LISTEN_FDS: descriptor " + std::to_string(fd) + ": " + std::strerror(errno)};
    }
    out.push_back({fd, family});
  }
  return out;
}

ServiceManager::ServiceManager() {
  const auto watched = takeVariable("WATCHDOG_PID");
  const auto interval = number(takeVariable("WATCHDOG_USEC"));
  const auto path = takeVariable("NOTIFY_SOCKET");
  // Longer than that is no address (unix(7)); '@' stands for the null byte of an abstract one.
  if (!path || path->empty() || path->size() >= sizeof(sockaddr_un::sun_path)) return;
  if (path->front() != '/' && path->front() != '@') return;
  address_ = *path;
  if (address_.front() == '@') address_.front() = '\0';
  socket_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const bool ours = !watched || number(watched) == ::getpid();
  if (ours && interval && *interval > 0) watchdog_ = std::chrono::microseconds(*interval / 2);
}

ServiceManager::~ServiceManager() {
  if (socket_ >= 0) ::close(socket_);
}

void ServiceManager::tell(const std::string& state) const {
  if (socket_ < 0) return;
  sockaddr_un to{};
  to.sun_family = AF_UNIX;
  std::copy(address_.begin(), address_.end(), to.sun_path);
  const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + address_.size());
  // As in every other place where the sockets interface wants its base type.
  const auto* address = static_cast<const sockaddr*>(static_cast<const void*>(&to));
  (void)::sendto(socket_, state.data(), state.size(), MSG_NOSIGNAL | MSG_DONTWAIT, address, size);
}

void ServiceManager::tellReloading() const {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  tell("RELOADING=1\nMONOTONIC_USEC=" +
       std::to_string(std::int64_t{now.tv_sec} * 1'000'000 + now.tv_nsec / 1000));
}

}  // namespace culld::server
