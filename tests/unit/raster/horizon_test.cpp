#include "culling/raster/horizon.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace culld {
namespace {

constexpr std::uint32_t kColumns = 100;  // no power of two

Horizon emptyHorizon(bool tree = true) {
  Horizon horizon;
  horizon.reset(kColumns, tree);
  return horizon;
}

TEST(Horizon, HidesNothingBeforeAnythingIsRaised) {
  Horizon horizon = emptyHorizon();
  EXPECT_FALSE(horizon.certainlyHidden({0, kColumns - 1, 0.0F, 1.0F}, 0.0F));
}

TEST(Horizon, HidesWhatIsFartherWithinTheRowsOfAllItsColumns) {
  Horizon horizon = emptyHorizon();
  const std::vector<RowSpan> wall(10, {2.0F, 8.0F});
  horizon.raise(20, wall, 0.5F);
  EXPECT_TRUE(horizon.certainlyHidden({20, 29, 2.0F, 8.0F}, 0.4F));
  EXPECT_FALSE(horizon.certainlyHidden({20, 30, 2.0F, 8.0F}, 0.4F));
  EXPECT_FALSE(horizon.certainlyHidden({19, 29, 2.0F, 8.0F}, 0.4F));
  EXPECT_FALSE(horizon.certainlyHidden({20, 29, 1.9F, 8.0F}, 0.4F)) << "sees below it";
  EXPECT_FALSE(horizon.certainlyHidden({20, 29, 2.0F, 8.1F}, 0.4F));
}

TEST(Horizon, HidesNothingAtTheSameNearness) {
  Horizon horizon = emptyHorizon();
  horizon.raise(0, std::vector<RowSpan>(10, {0.0F, 9.0F}), 0.5F);
  EXPECT_TRUE(horizon.certainlyHidden({2, 3, 1.0F, 2.0F}, std::nextafterf(0.5F, 0.0F)));
  EXPECT_FALSE(horizon.certainlyHidden({2, 3, 1.0F, 2.0F}, 0.5F));
}

TEST(Horizon, IsAsNearAsTheFarthestOfWhatRaisedIt) {
  Horizon horizon = emptyHorizon();
  horizon.raise(0, std::vector<RowSpan>(10, {0.0F, 9.0F}), 0.5F);
  horizon.raise(50, std::vector<RowSpan>(10, {0.0F, 9.0F}), 0.1F);
  EXPECT_FALSE(horizon.certainlyHidden({2, 3, 1.0F, 2.0F}, 0.3F));
  EXPECT_TRUE(horizon.certainlyHidden({2, 3, 1.0F, 2.0F}, 0.05F));
}

TEST(Horizon, JoinsRowsThatMeetAndKeepsTheLongerOfThoseThatDoNot) {
  Horizon horizon = emptyHorizon();
  const auto raise = [&](float low, float high) {
    horizon.raise(7, std::vector<RowSpan>(1, {low, high}), 0.5F);
  };
  raise(0.0F, 2.0F);
  raise(2.0F, 5.0F);
  EXPECT_TRUE(horizon.certainlyHidden({7, 7, 0.0F, 5.0F}, 0.1F)) << "two houses, one behind";
  raise(6.0F, 8.0F);
  EXPECT_FALSE(horizon.certainlyHidden({7, 7, 5.0F, 6.0F}, 0.1F)) << "a gap between them";
  EXPECT_TRUE(horizon.certainlyHidden({7, 7, 0.0F, 5.0F}, 0.1F));
  raise(10.0F, 30.0F);
  EXPECT_TRUE(horizon.certainlyHidden({7, 7, 10.0F, 30.0F}, 0.1F));
}

TEST(Horizon, KeepsWhatIsNotANumber) {
  Horizon horizon = emptyHorizon();
  horizon.raise(0, std::vector<RowSpan>(kColumns, {0.0F, 9.0F}), 0.5F);
  const float nan = std::nanf("");
  EXPECT_FALSE(horizon.certainlyHidden({0, 1, 1.0F, 2.0F}, nan));
  EXPECT_FALSE(horizon.certainlyHidden({0, 1, nan, 2.0F}, 0.1F));
  EXPECT_FALSE(horizon.certainlyHidden({0, 1, 1.0F, nan}, 0.1F));
  Horizon raised = emptyHorizon();
  raised.raise(0, std::vector<RowSpan>(kColumns, {0.0F, 9.0F}), nan);
  raised.raise(0, std::vector<RowSpan>(kColumns, {nan, nan}), 0.5F);
  EXPECT_FALSE(raised.certainlyHidden({0, 1, 1.0F, 2.0F}, 0.1F));
}

TEST(Horizon, FindsTheSameByItsTreeAsColumnByColumnWithFewerLooks) {
  std::mt19937_64 random(5);
  const auto real = [&](double low, double high) {
    return static_cast<float>(std::uniform_real_distribution<double>(low, high)(random));
  };
  Horizon tree = emptyHorizon(true), list = emptyHorizon(false);
  std::size_t hidden = 0;
  for (int i = 0; i < 4000; ++i) {
    if (i % 20 == 0) {
      const auto first = static_cast<std::uint32_t>(random() % kColumns);
      const std::size_t count = 1 + random() % (kColumns - first);
      const std::vector<RowSpan> spans(count, {real(0, 3), real(3, 12)});
      tree.raise(first, spans, 0.5F);
      list.raise(first, spans, 0.5F);
    }
    const auto x0 = static_cast<std::uint32_t>(random() % kColumns);
    const auto x1 = static_cast<std::uint32_t>(x0 + random() % (kColumns - x0));
    const ColumnRect rect{x0, x1, real(0, 5), real(5, 12)};
    const bool out = tree.certainlyHidden(rect, 0.1F);
    EXPECT_EQ(out, list.certainlyHidden(rect, 0.1F));
    hidden += out ? 1 : 0;
  }
  EXPECT_GT(hidden, 100U);
  EXPECT_LT(hidden, 3900U);
  EXPECT_LT(tree.looks(), list.looks());
}

}  // namespace
}  // namespace culld
