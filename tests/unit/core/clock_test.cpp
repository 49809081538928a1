#include "culling/core/clock.h"

#include <gtest/gtest.h>

#include <thread>

namespace culld {
namespace {

TEST(SteadyClock, NeverGoesBack) {
  const Clock& clock = steadyClock();
  auto last = clock.now();
  for (int i = 0; i < 100000; ++i) {
    const auto now = clock.now();
    ASSERT_GE(now, last);
    last = now;
  }
}

TEST(SteadyClock, MovesOnWhileAThreadSleeps) {
  const auto before = steadyClock().now();
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_GE(steadyClock().now() - before, std::chrono::milliseconds(5));
}

TEST(SteadyClock, IsOneAndTheSame) { EXPECT_EQ(&steadyClock(), &steadyClock()); }

}  // namespace
}  // namespace culld
