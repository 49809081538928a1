#include "culling/core/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

namespace culld {
namespace {

TEST(ParallelFor, DoesEveryPartOnceForAnyNumberOfThreads) {
  for (std::size_t threads : {0U, 1U, 2U, 3U, 16U}) {
    for (std::size_t count : {0U, 1U, 2U, 15U, 16U, 1000U}) {
      std::vector<std::atomic<int>> done(count);
      parallelFor(
          count, [&](std::size_t i) { ++done[i]; }, threads);
      for (const auto& times : done) ASSERT_EQ(times, 1) << threads << " threads, " << count;
    }
  }
}

TEST(ParallelFor, HasFinishedAllPartsWhenItReturns) {
  std::vector<int> results(64, 0);  // plain ints: a part still running would be a race
  parallelFor(
      64,
      [&](std::size_t i) {
        std::this_thread::sleep_for(std::chrono::microseconds(i % 7 * 100));
        results[i] = static_cast<int>(i) + 1;
      },
      4);
  for (std::size_t i = 0; i < 64; ++i) ASSERT_EQ(results[i], static_cast<int>(i) + 1);
}

TEST(ParallelFor, StaysOnTheCallersThreadWhenToldOne) {
  std::set<std::thread::id> seen;
  parallelFor(
      50, [&](std::size_t) { seen.insert(std::this_thread::get_id()); }, 1);
  EXPECT_EQ(seen, std::set{std::this_thread::get_id()});
}

TEST(ParallelFor, RunsPartsAtTheSameTimeWhenToldTwo) {
  std::atomic<int> waiting{0};
  // Each part waits for the other: this ends only if both run at once.
  parallelFor(
      2,
      [&](std::size_t) {
        ++waiting;
        while (waiting < 2) std::this_thread::yield();
      },
      2);
  EXPECT_EQ(waiting, 2);
}

TEST(ParallelFor, MayBeNested) {
  std::atomic<int> parts{0};
  parallelFor(
      4,
      [&](std::size_t) {
        parallelFor(
            5, [&](std::size_t) { ++parts; }, 2);
      },
      2);
  EXPECT_EQ(parts, 20);
}

}  // namespace
}  // namespace culld
