#include "client/sdk/backoff.h"

#include <gtest/gtest.h>

#include <set>
#include <vector>

namespace culld::client {
namespace {

using namespace std::chrono_literals;

std::vector<std::int64_t> waits(Backoff& backoff, std::size_t count) {
  std::vector<std::int64_t> ms;
  for (std::size_t i = 0; i < count; ++i) {
    const auto wait = backoff.next();
    if (!wait) break;
    ms.push_back(wait->count());
  }
  return ms;
}

TEST(Backoff, GrowsByTheFactorUpToTheLongest) {
  Backoff backoff({true, 100ms, 1000ms, 2.0, 0.0, 0}, 1);
  EXPECT_EQ(waits(backoff, 6), (std::vector<std::int64_t>{100, 200, 400, 800, 1000, 1000}));
  EXPECT_EQ(backoff.attempts(), 6U);
}

TEST(Backoff, StaysBoundedAfterThousandsOfAttempts) {
  Backoff backoff({true, 100ms, 1000ms, 10.0, 0.5, 0}, 1);
  for (int i = 0; i < 5000; ++i) {
    const auto wait = backoff.next();
    ASSERT_TRUE(wait.has_value());
    EXPECT_GE(*wait, i < 1 ? 50ms : 100ms);
    EXPECT_LE(*wait, 1000ms);
  }
}

TEST(Backoff, SpreadsClientsByJitter) {
  std::set<std::int64_t> first;
  for (std::uint32_t seed = 1; seed <= 50; ++seed) {
    Backoff backoff({true, 1000ms, 1000ms, 2.0, 0.5, 0}, seed);
    const auto wait = backoff.next().value().count();
    EXPECT_GE(wait, 500);
    EXPECT_LE(wait, 1000);
    first.insert(wait);
  }
  EXPECT_GT(first.size(), 25U);
}

TEST(Backoff, GivesUpAfterTheAttemptsAllowed) {
  Backoff backoff({true, 10ms, 100ms, 2.0, 0.0, 3}, 1);
  EXPECT_EQ(waits(backoff, 9).size(), 3U);
  Backoff off({false, 10ms, 100ms, 2.0, 0.0, 0}, 1);
  EXPECT_TRUE(waits(off, 9).empty());
}

TEST(Backoff, BeginsSmallAgainOnlyAfterAConnectionThatHeld) {
  Backoff backoff({true, 10ms, 100ms, 2.0, 0.0, 0}, 1);
  waits(backoff, 3);
  backoff.held(99ms);
  EXPECT_EQ(backoff.next(), 80ms);
  backoff.held(100ms);
  EXPECT_EQ(backoff.next(), 10ms);
}

TEST(Backoff, MakesSenseOfRulesThatMakeNone) {
  Backoff backoff({true, -5ms, -7ms, 0.1, 9.0, 0}, 1);
  for (int i = 0; i < 9; ++i) {
    const auto wait = backoff.next();
    ASSERT_TRUE(wait.has_value());
    EXPECT_GE(*wait, 0ms);
    EXPECT_LE(*wait, 1ms);
  }
}

}  // namespace
}  // namespace culld::client
