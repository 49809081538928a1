// What a tenant may use of the server, and how much of that it has used. Time comes in from
// outside, so tests own it.
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

namespace culld::server {

using Time = std::chrono::nanoseconds;  ///< as Clock::now()

/// A token bucket that is charged after the fact, as what work costs is known once it is done: it
/// is open while its level is above zero, and may go below. Holds what a second brings.
class TokenBucket {
 public:
  /// `per_s` 0: never closes.
  explicit TokenBucket(std::uint64_t per_s = 0);

  void charge(double amount, Time now);
  /// How long until it opens; zero: it is open.
  std::chrono::nanoseconds wait(Time now);
  /// Keeps the level as far as the new rate allows.
  void setRate(std::uint64_t per_s);

 private:
  void refill(Time now);

  double per_s_;
  double level_;
  std::optional<Time> filled_;  ///< none: never used, hence full
};

/// 0: no limit.
struct Quotas {
  std::uint64_t cull_ms_per_s = 0;
  std::uint64_t bytes_per_s = 0;
  std::uint64_t scenes = 0;

  bool operator==(const Quotas&) const = default;
};

enum class QuotaReason : std::uint8_t { kCull, kBytes, kScenes, kTickets };
const char* nameOf(QuotaReason reason) noexcept;

/// Why nothing more is done for a tenant just now.
struct QuotaRefusal {
  QuotaReason reason = QuotaReason::kCull;
  std::string message;  ///< "tenant acme: ..."
  std::chrono::seconds retry_after{1};
};

/// A customer, a team: whoever pays together. Outlives a reload of the tokens, with its debts.
/// THREADS: any.
class Tenant {
 public:
  explicit Tenant(std::string name, Quotas quotas = {});

  /// Empty: the operator, who has no limits and whose scenes are everyone's to see.
  const std::string& name() const noexcept { return name_; }
  void setQuotas(const Quotas& quotas);

  void culled(std::chrono::nanoseconds took, Time now);
  void sent(std::size_t bytes, Time now);
  /// Why no camera may be answered.
  std::optional<QuotaRefusal> refuseCull(Time now);
  /// Why no HTTP request may be answered, nor a live session begin.
  std::optional<QuotaRefusal> refuseBytes(Time now);
  /// Why a scene under a new name may not come to those `held`.
  std::optional<QuotaRefusal> refuseScene(std::size_t held) const;

  /// Held from counting this tenant's scenes until one more is there.
  std::mutex& sceneChanges() noexcept { return scene_changes_; }

 private:
  std::optional<QuotaRefusal> bytesRefusal(Time now);

  const std::string name_;
  std::mutex scene_changes_;
  mutable std::mutex mutex_;  ///< guards the rest
  Quotas quotas_;
  TokenBucket cull_ns_;
  TokenBucket bytes_;
};

using TenantPtr = std::shared_ptr<Tenant>;

}  // namespace culld::server
