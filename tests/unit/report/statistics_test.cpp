#include "culling/report/statistics.h"

#include <gtest/gtest.h>

#include <limits>

namespace culld::report {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Percentile, LiesBetweenNeighbours) {
  const std::vector<double> values{1, 2, 3, 4, 5};
  EXPECT_DOUBLE_EQ(percentile(values, 0.0), 1);
  EXPECT_DOUBLE_EQ(percentile(values, 0.5), 3);
  EXPECT_DOUBLE_EQ(percentile(values, 0.95), 4.8);
  EXPECT_DOUBLE_EQ(percentile(values, 1.0), 5);
  EXPECT_DOUBLE_EQ(percentile(std::vector<double>{1, 2}, 0.5), 1.5);
}

TEST(Percentile, OfOneValueIsThatValueAndOfNothingZero) {
  EXPECT_DOUBLE_EQ(percentile(std::vector<double>{7}, 0.95), 7);
  EXPECT_DOUBLE_EQ(percentile({}, 0.5), 0);
}

TEST(Spread, SortsWhatItGets) {
  const Spread spread = spreadOf({5, 1, 4, 2, 3});
  EXPECT_DOUBLE_EQ(spread.min, 1);
  EXPECT_DOUBLE_EQ(spread.median, 3);
  EXPECT_DOUBLE_EQ(spread.p95, 4.8);
  EXPECT_DOUBLE_EQ(spread.max, 5);
}

TEST(Spread, LeavesOutWhatIsNoNumber) {
  const Spread spread = spreadOf({kNan, 2, std::numeric_limits<double>::infinity()});
  EXPECT_DOUBLE_EQ(spread.min, 2);
  EXPECT_DOUBLE_EQ(spread.max, 2);
  EXPECT_DOUBLE_EQ(spreadOf({kNan}).max, 0);
  EXPECT_DOUBLE_EQ(spreadOf({}).median, 0);
}

TEST(ParetoFront, HoldsWhatNothingBeats) {
  const std::vector<Cost> points{{1, 10}, {2, 5}, {3, 6}, {4, 1}, {5, 1}};
  EXPECT_EQ(paretoFront(points), (std::vector<std::size_t>{0, 1, 3}));
}

TEST(ParetoFront, GoesByAscendingTimeWhateverTheOrderOfThePoints) {
  const std::vector<Cost> points{{4, 1}, {1, 10}, {2, 5}};
  EXPECT_EQ(paretoFront(points), (std::vector<std::size_t>{1, 2, 0}));
}

TEST(ParetoFront, TakesTheFirstOfEqualPoints) {
  const std::vector<Cost> points{{1, 1}, {1, 1}, {1, 2}};
  EXPECT_EQ(paretoFront(points), (std::vector<std::size_t>{0}));
}

TEST(ParetoFront, IsBlindToWhatIsNoNumber) {
  const std::vector<Cost> points{{kNan, 0}, {0, kNan}, {3, 3}};
  EXPECT_EQ(paretoFront(points), (std::vector<std::size_t>{2}));
  EXPECT_TRUE(paretoFront({}).empty());
}

}  // namespace
}  // namespace culld::report
