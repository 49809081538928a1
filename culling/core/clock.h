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

/// A moment after which work is cut short. Zero time: never.
class Deadline {
 public:
  Deadline(const Clock& clock, std::chrono::nanoseconds start, std::chrono::nanoseconds time)
      : clock_(clock), end_(start + time), limited_(time.count() > 0) {}
  bool passed() const noexcept { return limited_ && clock_.now() >= end_; }

 private:
  const Clock& clock_;
  std::chrono::nanoseconds end_;
  bool limited_;
};

}  // namespace culld
