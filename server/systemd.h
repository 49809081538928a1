// The two small protocols of systemd for daemons: sockets handed over (sd_listen_fds(3)) and states
// told (sd_notify(3)). A few lines each, so no library is linked for them.
#pragma once
#include <chrono>
#include <string>
#include <string_view>
#include <vector>

#include "culling/core/result.h"

namespace culld::server {

/// A listening stream socket that somebody else opened.
struct InheritedSocket {
  int descriptor = -1;
  int family = 0;  ///< AF_INET, AF_INET6, AF_UNIX
};

/// The sockets that were handed to this process; the descriptors are the caller's. Takes the
/// variables out of the environment. ERROR: kInvalidInput, one of them is something else.
/// THREADS: before others run.
Result<std::vector<InheritedSocket>> inheritedSockets();

/// Tells the service manager, if there is one, what this process is up to. THREADS: any.
class ServiceManager {
 public:
  /// Takes its variables out of the environment.
  ServiceManager();
  ~ServiceManager();
  ServiceManager(const ServiceManager&) = delete;
  ServiceManager& operator=(const ServiceManager&) = delete;

  /// READY=1 and the like, a line each. What nobody takes is lost, as sd_notify(3) has it.
  void tell(const std::string& state) const;
  /// RELOADING=1 with the time that Type=notify-reload asks for.
  void tellReloading() const;
  /// How often it wants to hear WATCHDOG=1 at least, halved; 0: never.
  std::chrono::microseconds watchdogInterval() const noexcept { return watchdog_; }

 private:
  int socket_ = -1;
  std::string address_;
  std::chrono::microseconds watchdog_{0};
};

}  // namespace culld::server
