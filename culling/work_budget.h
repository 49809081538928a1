// What one frame of a method that draws occluders may use: time by the clock, and counted work.
#pragma once
#include <chrono>
#include <cstdint>

#include "culling/core/clock.h"
#include "culling/occluders/occluder_drawing.h"

namespace culld {

/// Work is what was drawn, which this adds up, and what the method counts beside that and names
/// with each call (`counted_ns`).
class WorkBudget {
 public:
  /// Keeps a reference to the deadline. `most_work`: 0 is no limit.
  WorkBudget(const Deadline& deadline, std::chrono::nanoseconds most_work)
      : deadline_(deadline), most_work_(most_work) {}

  /// False once time or work is used up. The clock is asked every few calls.
  bool mayGoOn(std::uint64_t counted_ns) {
    if (to_look_-- == 0) lookAtClock();
    stopped_ = stopped_ || (limited() && work(counted_ns) >= most_work_);
    return !stopped_;
  }
  /// After a call that took long: the next one asks the clock.
  void lookNext() { to_look_ = 0; }

  void drew(const DrawnOccluder& drawn) {
    drawing_ns_ += drawn.work_ns;
    stopped_ = stopped_ || drawn.cut_short;
  }
  void stop() { stopped_ = true; }
  bool stopped() const noexcept { return stopped_; }

  std::chrono::nanoseconds work(std::uint64_t counted_ns) const noexcept {
    return std::chrono::nanoseconds(counted_ns + drawing_ns_);
  }
  /// What drawing an occluder may still take.
  std::uint64_t leftNs(std::uint64_t counted_ns) const noexcept {
    if (!limited()) return OccluderDrawing::kNoLimit;
    const auto left = (most_work_ - work(counted_ns)).count();
    return left > 0 ? static_cast<std::uint64_t>(left) : 0;
  }

 private:
  static constexpr std::uint32_t kCallsPerLook = 16;

  bool limited() const noexcept { return most_work_.count() != 0; }
  void lookAtClock() {
    to_look_ = kCallsPerLook - 1;
    stopped_ = stopped_ || deadline_.passed();
  }

  const Deadline& deadline_;
  std::chrono::nanoseconds most_work_;
  std::uint64_t drawing_ns_ = 0;
  std::uint32_t to_look_ = 0;
  bool stopped_ = false;
};

}  // namespace culld
