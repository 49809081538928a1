// How fast one client may talk: messages beyond the rate are read later, not refused, so that TCP
// slows the sender down. Without I/O; time is told.
#pragma once
#include <algorithm>
#include <chrono>
#include <cstdint>

namespace culld::server {

/// Lets a tenth of a second's worth through at once, then evens out (the virtual scheduling of
/// ITU-T I.371, known as GCRA).
class MessageRate {
 public:
  /// 0: any rate.
  explicit MessageRate(std::uint32_t per_s)
      : interval_(per_s == 0 ? 0 : kSecond / per_s),
        burst_(std::max(interval_, std::chrono::nanoseconds(kSecond / 10))) {}

  /// Counts a message that was read; says how long to wait before the next is.
  std::chrono::nanoseconds count(std::chrono::nanoseconds now) {
    next_ = std::max(next_, now) + interval_;
    return std::max(std::chrono::nanoseconds(0), next_ - now - burst_);
  }

 private:
  static constexpr std::int64_t kSecond = 1'000'000'000;
  std::chrono::nanoseconds interval_;
  std::chrono::nanoseconds burst_;
  std::chrono::nanoseconds next_{0};  ///< when the next message is due at an even pace
};

}  // namespace culld::server
