#include "culling/report/svg.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace culld::report {
namespace {

std::vector<double> valuesOf(const std::vector<Tick>& ticks) {
  std::vector<double> values;
  for (const Tick& tick : ticks) values.push_back(tick.value);
  return values;
}

void expectNear(const std::vector<double>& got, const std::vector<double>& expected) {
  ASSERT_EQ(got.size(), expected.size());
  for (std::size_t i = 0; i < got.size(); ++i) {
    EXPECT_NEAR(got[i], expected[i], 1e-9 * std::abs(expected[i]) + 1e-300);
  }
}

TEST(LogTicks, AreFinerWhereTheRangeIsShort) {
  expectNear(valuesOf(logTicks(0.9, 1100)), {1, 10, 100, 1000});
  expectNear(valuesOf(logTicks(0.9, 60)), {1, 2, 5, 10, 20, 50});
  expectNear(valuesOf(logTicks(1, 8)), {1, 1.5, 2, 3, 5, 7});
  expectNear(valuesOf(logTicks(1.02, 1.08)), {1.02, 1.04, 1.06, 1.08});
}

TEST(LogTicks, StayFewOverAHugeRange) {
  const auto ticks = logTicks(1e-12, 1e12);
  EXPECT_GE(ticks.size(), 3U);
  EXPECT_LE(ticks.size(), 8U);
}

TEST(LinearTicks, AreRoundAndInside) {
  expectNear(valuesOf(linearTicks(0, 10)), {0, 2, 4, 6, 8, 10});
  expectNear(valuesOf(linearTicks(-0.3, 0.31)), {-0.2, 0, 0.2});
  for (const Tick& tick : linearTicks(-1, 1)) EXPECT_NE(tick.label, "-0");
}

TEST(LogAxis, PutsEqualRatiosAtEqualDistances) {
  const Axis axis(Axis::Kind::kLog, {1, 1000}, 0, 300);
  EXPECT_NEAR(axis.at(10) - axis.at(1), axis.at(100) - axis.at(10), 1e-9);
  EXPECT_GT(axis.at(1), 0);
  EXPECT_LT(axis.at(1000), 300);
}

TEST(LogAxisWithZero, GivesZeroAPlaceOfItsOwn) {
  const Axis axis(Axis::Kind::kLogWithZero, {0, 1, 1000}, 300, 0);
  EXPECT_LT(axis.at(1), axis.breakAt());
  EXPECT_GT(axis.at(0), axis.breakAt());
  EXPECT_LT(axis.at(0), 300);
  EXPECT_EQ(axis.ticks().front().label, "0");
}

TEST(Axis, HasARangeForOneValueForNoneAndForNoNumbers) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const Axis::Kind kind : {Axis::Kind::kLinear, Axis::Kind::kLog, Axis::Kind::kLogWithZero}) {
    for (const std::vector<double>& values :
         {std::vector<double>{}, {5.0}, {0.0}, {0.0, 0.0}, {kNan}, {-3.0}, {1e300, 1e-300}}) {
      const Axis axis(kind, values, 0, 100);
      EXPECT_FALSE(axis.ticks().empty());
      for (const double value : values) {
        if (std::isfinite(value)) {
          EXPECT_TRUE(std::isfinite(axis.at(value))) << value;
        }
      }
    }
  }
}

TEST(ShortNumber, HasThreeSignificantDigits) {
  EXPECT_EQ(shortNumber(0), "0");
  EXPECT_EQ(shortNumber(1), "1");
  EXPECT_EQ(shortNumber(12.345), "12.3");
  EXPECT_EQ(shortNumber(0.012345), "0.0123");
  EXPECT_EQ(shortNumber(999.7), "1\u2009000");
  EXPECT_EQ(shortNumber(1234567), "1\u2009234\u2009567");
  EXPECT_EQ(shortNumber(-1234), "-1\u2009234");
  EXPECT_EQ(shortNumber(2.5e15), "2.5e+15");
  EXPECT_EQ(shortNumber(std::nan("")), "-");
}

TEST(ShortTimesAndBytes, TakeTheUnitThatFits) {
  EXPECT_EQ(shortTime(0.85), "850 ns");
  EXPECT_EQ(shortTime(12.3), "12.3 \u00b5s");
  EXPECT_EQ(shortTime(4500), "4.5 ms");
  EXPECT_EQ(shortTime(2.1e6), "2.1 s");
  EXPECT_EQ(shortBytes(640), "640 B");
  EXPECT_EQ(shortBytes(1536), "1.54 kB");
  EXPECT_EQ(shortBytes(3.2e9), "3.2 GB");
}

TEST(Percent, HasOneDigitAfterThePointAndNoNegativeZero) {
  EXPECT_EQ(percent(0.8844), "88.4 %");
  EXPECT_EQ(percent(-0.0001), "0.0 %");
  EXPECT_EQ(percent(-0.016), "-1.6 %");
  EXPECT_EQ(percent(std::nullopt), "-");
}

TEST(Escaped, LeavesNoMarkupAndNoBrokenCharacters) {
  EXPECT_EQ(escaped("<a href=\"x\">&"), "&lt;a href=&quot;x&quot;&gt;&amp;");
  EXPECT_EQ(escaped("caf\u00e9"), "caf\u00e9");
  EXPECT_EQ(escaped("\xff\x80 \xe2\x82"), "?? ??");
  EXPECT_EQ(escaped(std::string_view("\x01z", 2)), "?z");
}

TEST(Marker, DiffersInShapeAndColourBetweenSeries) {
  for (std::size_t a = 0; a < kStyles; ++a) {
    for (std::size_t b = a + 1; b < kStyles; ++b) {
      const Style one = styleOf(a), other = styleOf(b);
      const bool same_color = std::string_view(one.color) == other.color;
      EXPECT_EQ(same_color, b - a == 7) << a << " " << b;
      if (same_color) {
        EXPECT_STRNE(one.dash, other.dash) << a << " " << b;
      }
      if (same_color || one.shape == other.shape) {
        EXPECT_NE(one.hollow, other.hollow) << a << " " << b;
      }
      EXPECT_NE(marker(a, 0, 0, 4), marker(b, 0, 0, 4)) << a << " " << b;
    }
  }
}

}  // namespace
}  // namespace culld::report
