#include "server/quota.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace culld::server {
namespace {

constexpr std::uint64_t kNsPerMs = 1'000'000;
/// A scene goes when somebody removes it, which no clock foretells.
constexpr std::chrono::seconds kSceneRetry{60};

std::string rate(std::uint64_t amount, const char* unit) {
  return std::to_string(amount) + " " + unit + " per second are used up";
}

std::chrono::seconds wholeSeconds(std::chrono::nanoseconds wait) {
  return std::max(std::chrono::ceil<std::chrono::seconds>(wait), std::chrono::seconds(1));
}

}  // namespace

TokenBucket::TokenBucket(std::uint64_t per_s)
    : per_s_(static_cast<double>(per_s)), level_(static_cast<double>(per_s)) {}

void TokenBucket::refill(Time now) {
  if (filled_ && now > *filled_) {
    level_ =
        std::min(level_ + per_s_ * std::chrono::duration<double>(now - *filled_).count(), per_s_);
  }
  if (!filled_ || now > *filled_) filled_ = now;
}

void TokenBucket::charge(double amount, Time now) {
  if (per_s_ <= 0) return;
  refill(now);
  level_ -= amount;
}

std::chrono::nanoseconds TokenBucket::wait(Time now) {
  if (per_s_ <= 0) return {};
  refill(now);
  if (level_ > 0) return {};
  // At the level of zero it is still shut; a nanosecond's worth opens it.
  constexpr double kLongest = 1e9 * 86400 * 365;
  return std::chrono::nanoseconds(
      static_cast<std::int64_t>(std::min(-level_ / per_s_ * 1e9, kLongest)) + 1);
}

void TokenBucket::setRate(std::uint64_t per_s) {
  const auto fresh = static_cast<double>(per_s);
  level_ = per_s_ <= 0 ? fresh : std::min(level_, fresh);
  per_s_ = fresh;
}

const char* nameOf(QuotaReason reason) noexcept {
  switch (reason) {
    case QuotaReason::kCull:
      return "cull";
    case QuotaReason::kBytes:
      return "bytes";
    case QuotaReason::kScenes:
      return "scenes";
    case QuotaReason::kTickets:
      break;
  }
  return "tickets";
}

Tenant::Tenant(std::string name, Quotas quotas) : name_(std::move(name)) { setQuotas(quotas); }

void Tenant::setQuotas(const Quotas& quotas) {
  const std::lock_guard lock(mutex_);
  quotas_ = quotas;
  cull_ns_.setRate(quotas.cull_ms_per_s * kNsPerMs);
  bytes_.setRate(quotas.bytes_per_s);
}

void Tenant::culled(std::chrono::nanoseconds took, Time now) {
  const std::lock_guard lock(mutex_);
  cull_ns_.charge(static_cast<double>(took.count()), now);
}

void Tenant::sent(std::size_t bytes, Time now) {
  const std::lock_guard lock(mutex_);
  bytes_.charge(static_cast<double>(bytes), now);
}

std::optional<QuotaRefusal> Tenant::refuseCull(Time now) {
  const std::lock_guard lock(mutex_);
  if (const auto wait = cull_ns_.wait(now); wait.count() > 0) {
    return QuotaRefusal{QuotaReason::kCull,
                        "tenant " + name_ + ": " + rate(quotas_.cull_ms_per_s, "ms of culling"),
                        wholeSeconds(wait)};
  }
  return bytesRefusal(now);
}

std::optional<QuotaRefusal> Tenant::refuseBytes(Time now) {
  const std::lock_guard lock(mutex_);
  return bytesRefusal(now);
}

std::optional<QuotaRefusal> Tenant::bytesRefusal(Time now) {
  const auto wait = bytes_.wait(now);
  if (wait.count() <= 0) return std::nullopt;
  return QuotaRefusal{QuotaReason::kBytes,
                      "tenant " + name_ + ": " + rate(quotas_.bytes_per_s, "bytes"),
                      wholeSeconds(wait)};
}

std::optional<QuotaRefusal> Tenant::refuseScene(std::size_t held) const {
  const std::lock_guard lock(mutex_);
  if (quotas_.scenes == 0 || held < quotas_.scenes) return std::nullopt;
  return QuotaRefusal{
      QuotaReason::kScenes,
      "tenant " + name_ + ": " + std::to_string(quotas_.scenes) + " scenes are its share",
      kSceneRetry};
}

}  // namespace culld::server
