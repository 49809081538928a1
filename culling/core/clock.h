// Time comes in from outside: the engine never asks the system clock itself, so tests own time.
#pragma once
#include <chrono>

namespace culld {

class Clock {
 public:
  virtual ~Clock() = default;
  /// Monotonic time since an arbitrary start. THREADS: any.
  virtual std::chrono::nanoseconds now() const noexcept = 0;
};

/// The machine's monotonic clock.
const Clock& steadyClock() noexcept;

}  // namespace culld
