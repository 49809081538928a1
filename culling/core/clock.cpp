#include "culling/core/clock.h"

namespace culld {
namespace {

class SteadyClock final : public Clock {
 public:
  std::chrono::nanoseconds now() const noexcept override {
    return std::chrono::steady_clock::now().time_since_epoch();
  }
};

}  // namespace

const Clock& steadyClock() noexcept {
  static const SteadyClock clock;
  return clock;
}

}  // namespace culld
