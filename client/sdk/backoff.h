// How long to wait before the next attempt to connect. The rule is that of struct Reconnect.
#pragma once
#include <chrono>
#include <cstdint>
#include <optional>
#include <random>

#include "culld/options.h"

namespace culld::client {

/// THREADS: one at a time.
class Backoff {
 public:
  /// Bounds that make no sense are moved to the nearest that do.
  Backoff(const Reconnect& rule, std::uint32_t seed);

  /// The next wait; none: give up.
  std::optional<std::chrono::milliseconds> next();
  /// The connection has held for so long.
  void held(std::chrono::nanoseconds time);
  std::uint32_t attempts() const noexcept { return attempts_; }

 private:
  Reconnect rule_;
  std::minstd_rand random_;
  std::uint32_t attempts_ = 0;  ///< since it last held
};

}  // namespace culld::client
