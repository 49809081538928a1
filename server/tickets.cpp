#include "server/tickets.h"

#include <algorithm>

namespace culld::server {

std::optional<std::variant<std::string, QuotaRefusal>> Tickets::issue(const Grant& grant,
                                                                      Time now) {
  const std::lock_guard lock(mutex_);
  dropStale(now);
  std::size_t held = 0;
  Time soonest = Time::max();
  for (const auto& [digest, ticket] : held_) {
    if (ticket.grant.tenant != grant.tenant) continue;
    ++held;
    soonest = std::min(soonest, ticket.stale);
  }
  if (held >= limits_.per_tenant) {
    return QuotaRefusal{QuotaReason::kTickets,
                        std::to_string(held) + " tickets wait to be used, and no more are made",
                        std::chrono::ceil<std::chrono::seconds>(soonest - now)};
  }
  auto ticket = freshSecret();
  if (!ticket) return std::nullopt;
  held_.insert_or_assign(sha256(*ticket), Held{grant, now + limits_.lifetime});
  return *std::move(ticket);
}

std::optional<Grant> Tickets::redeem(std::string_view ticket, Time now) {
  const std::lock_guard lock(mutex_);
  dropStale(now);
  auto found = held_.extract(sha256(ticket));
  if (found.empty()) return std::nullopt;
  return std::move(found.mapped().grant);
}

void Tickets::clear() {
  const std::lock_guard lock(mutex_);
  held_.clear();
}

void Tickets::dropStale(Time now) {
  std::erase_if(held_, [now](const auto& entry) { return entry.second.stale <= now; });
}

}  // namespace culld::server
