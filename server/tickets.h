// Tickets: a browser cannot send a token when it opens a WebSocket, so it trades the token for a
// word that is good once and soon stale (docs/protocol.md "Tickets").
#pragma once
#include <chrono>
#include <cstddef>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "server/grant.h"

namespace culld::server {

struct TicketLimits {
  std::chrono::seconds lifetime{30};
  std::size_t per_tenant = 256;
};

/// THREADS: any.
class Tickets {
 public:
  explicit Tickets(const TicketLimits& limits) : limits_(limits) {}

  std::chrono::seconds lifetime() const noexcept { return limits_.lifetime; }
  /// A fresh ticket that stands for `grant`; or why there is none. None at all: no randomness.
  std::optional<std::variant<std::string, QuotaRefusal>> issue(const Grant& grant, Time now);
  /// What the ticket stands for, and it is gone.
  std::optional<Grant> redeem(std::string_view ticket, Time now);
  void clear();

 private:
  struct Held {
    Grant grant;
    Time stale{0};
  };
  void dropStale(Time now);

  const TicketLimits limits_;
  std::mutex mutex_;
  std::map<TokenDigest, Held>
      held_;  ///< by the ticket's digest, so that timing tells nothing of it
};

}  // namespace culld::server
