#include "culling/work_budget.h"

#include <gtest/gtest.h>

namespace culld {
namespace {

using std::chrono::nanoseconds;

/// Counts how often it was asked.
class CountingClock final : public Clock {
 public:
  nanoseconds now() const noexcept override {
    ++looks;
    return time;
  }
  nanoseconds time{0};
  mutable int looks = 0;
};

TEST(WorkBudget, WithoutLimitsNeverEnds) {
  const CountingClock clock;
  const Deadline never(clock, nanoseconds(0), nanoseconds(0));
  WorkBudget budget(never, nanoseconds(0));
  budget.drew({1, 1'000'000'000, false});
  EXPECT_TRUE(budget.mayGoOn(1'000'000'000));
  EXPECT_EQ(budget.leftNs(5), OccluderDrawing::kNoLimit);
  EXPECT_EQ(budget.work(5), nanoseconds(1'000'000'005));
}

TEST(WorkBudget, EndsWithItsWork) {
  const CountingClock clock;
  const Deadline never(clock, nanoseconds(0), nanoseconds(0));
  WorkBudget budget(never, nanoseconds(100));
  EXPECT_TRUE(budget.mayGoOn(10));
  budget.drew({1, 60, false});
  EXPECT_EQ(budget.leftNs(10), 30U);
  EXPECT_TRUE(budget.mayGoOn(39));
  EXPECT_FALSE(budget.mayGoOn(40));
  EXPECT_EQ(budget.leftNs(50), 0U);
  EXPECT_FALSE(budget.mayGoOn(0)) << "for good";
  EXPECT_TRUE(budget.stopped());
}

TEST(WorkBudget, AsksTheClockAtOnceThenEverySixteenCallsOrWhenTold) {
  CountingClock clock;
  const Deadline deadline(clock, nanoseconds(0), nanoseconds(100));
  WorkBudget budget(deadline, nanoseconds(0));
  for (int call = 0; call < 33; ++call) EXPECT_TRUE(budget.mayGoOn(0));
  EXPECT_EQ(clock.looks, 3);
  clock.time = nanoseconds(100);
  EXPECT_TRUE(budget.mayGoOn(0));
  budget.lookNext();
  EXPECT_FALSE(budget.mayGoOn(0));
}

TEST(WorkBudget, EndsWithADrawingThatWasCutShort) {
  const CountingClock clock;
  const Deadline never(clock, nanoseconds(0), nanoseconds(0));
  WorkBudget budget(never, nanoseconds(0));
  budget.drew({1, 1, true});
  EXPECT_FALSE(budget.mayGoOn(0));
}

}  // namespace
}  // namespace culld
