#include "culling/spatial/frustum_walk.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>

#include "culling/core/simd.h"
#include "tests/unit/spatial/box_scene.h"
#include "tests/unit/spatial/exact.h"

namespace culld::testing {
namespace {

/// Moves on by a fixed step whenever somebody looks at it.
class TickingClock final : public Clock {
 public:
  std::chrono::nanoseconds now() const noexcept override {
    return std::chrono::nanoseconds(1000 * ++looks_);
  }

 private:
  mutable std::atomic<long> looks_{0};
};

Camera someCamera(std::mt19937_64& random, const glm::dvec3& centre, double extent) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  LookAt look;
  look.eye = centre + extent * glm::dvec3(unit(random), unit(random), unit(random));
  look.target = centre + extent * glm::dvec3(unit(random), unit(random), unit(random));
  look.yfov_rad = 0.02 + 1.4 * (1.0 + unit(random));
  look.znear_m = extent * 1e-4;
  if (random() % 2 == 0) look.zfar_m = extent * (1.1 + unit(random));
  return cameraFromLookAt(look, {}).value();
}

std::vector<ObjectId> inFrustum(const WideBvh& bvh, const Camera& camera, std::size_t limit) {
  std::vector<ObjectId> ids;
  const Deadline never(steadyClock(), {}, {});
  const FrustumWalkStats stats = appendInFrustum(bvh, FrustumTest(camera, bvh), never, ids);
  EXPECT_FALSE(stats.out_of_time);
  sortIds(ids, limit);
  return ids;
}

class FrustumWalk : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { ASSERT_TRUE(forceSimdTarget(GetParam()).ok()); }
  void TearDown() override { ASSERT_TRUE(forceSimdTarget("auto").ok()); }
};

TEST_P(FrustumWalk, LeavesOutOnlyWhatIsOutsideAndKeepsLittleElse) {
  std::mt19937_64 random(5);
  std::size_t answered = 0, left_out = 0;
  for (const glm::dvec3& centre : {glm::dvec3(0, 0, 0), glm::dvec3(1e7, -2e6, 3e5)}) {
    const auto scene = boxScene(randomBoxes(3000, centre, 50.0, 17));
    const WideBvh bvh = WideBvh::build(*scene);
    for (int n = 0; n < 40; ++n) {
      const Camera camera = someCamera(random, centre, 50.0);
      const std::vector<ObjectId> ids = inFrustum(bvh, camera, scene->objectCount());
      answered += ids.size();
      for (ObjectId id = 0; id < scene->objectCount(); ++id) {
        const Box& box = scene->instance(id).bounds_world;
        if (!std::binary_search(ids.begin(), ids.end(), id)) {
          ++left_out;
          ASSERT_TRUE(outsideExactly(camera, box)) << id;
        } else {
          ASSERT_FALSE(clearlyOutside(camera, box, 1e-5)) << id;
        }
      }
    }
  }
  EXPECT_GT(answered, 5000U);
  EXPECT_GT(left_out, 5000U);
}

TEST_P(FrustumWalk, GivesTheSameIdsAsOnEveryOtherTarget) {
  std::mt19937_64 random(6);
  const auto scene = boxScene(randomBoxes(20000, {6.4e6, 0, 0}, 200.0, 18));
  const WideBvh bvh = WideBvh::build(*scene);
  for (int n = 0; n < 50; ++n) {
    const Camera camera = someCamera(random, {6.4e6, 0, 0}, 200.0);
    const std::vector<ObjectId> here = inFrustum(bvh, camera, scene->objectCount());
    for (const std::string& other : simdTargets()) {
      ASSERT_TRUE(forceSimdTarget(other).ok());
      ASSERT_EQ(here, inFrustum(bvh, camera, scene->objectCount())) << other;
    }
    ASSERT_TRUE(forceSimdTarget(GetParam()).ok());
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, FrustumWalk, ::testing::ValuesIn(simdTargets()),
                         [](const auto& target) { return target.param; });

TEST(FrustumWalkTime, KeepsEverythingUndecidedWhenTimeRunsOut) {
  std::mt19937_64 random(7);
  const auto scene = boxScene(randomBoxes(20000, {0, 0, 0}, 100.0, 19));
  const WideBvh bvh = WideBvh::build(*scene);
  for (int n = 0; n < 20; ++n) {
    const Camera camera = someCamera(random, {0, 0, 0}, 100.0);
    const std::vector<ObjectId> all = inFrustum(bvh, camera, scene->objectCount());
    std::size_t fewest = scene->objectCount();
    for (int looks : {1, 2, 3, 5, 8}) {
      const TickingClock clock;
      const Deadline deadline(clock, clock.now(), std::chrono::nanoseconds(1000 * looks));
      std::vector<ObjectId> cut;
      const auto stats = appendInFrustum(bvh, FrustumTest(camera, bvh), deadline, cut);
      sortIds(cut, scene->objectCount());
      ASSERT_TRUE(std::includes(cut.begin(), cut.end(), all.begin(), all.end()));
      ASSERT_EQ(std::adjacent_find(cut.begin(), cut.end()), cut.end());
      ASSERT_TRUE(stats.out_of_time || cut == all);
      ASSERT_LE(cut.size(), fewest);  // more time, fewer undecided
      fewest = cut.size();
      if (looks == 1) {
        ASSERT_EQ(stats.nodes_visited, 0U);
        ASSERT_EQ(cut.size(), scene->objectCount());
      }
    }
  }
}

TEST(FrustumWalkTime, NeverAsksTheClockWithoutALimit) {
  const TickingClock clock;
  const Deadline deadline(clock, std::chrono::nanoseconds(0), std::chrono::nanoseconds(0));
  EXPECT_FALSE(deadline.passed());
  EXPECT_EQ(clock.now().count(), 1000);
}

TEST(SortIds, GivesTheSameByMarkingAsBySorting) {
  std::mt19937_64 random(8);
  for (std::size_t limit : {1U, 63U, 64U, 65U, 100000U}) {
    for (std::size_t step : {1U, 2U, 7U, 1000U, 99999U}) {
      std::vector<ObjectId> ids;
      for (std::size_t id = 0; id < limit; id += step) ids.push_back(static_cast<ObjectId>(id));
      std::vector<ObjectId> mixed = ids;
      std::shuffle(mixed.begin(), mixed.end(), random);
      sortIds(mixed, limit);
      ASSERT_EQ(mixed, ids) << limit << " " << step;
    }
  }
  std::vector<ObjectId> none;
  sortIds(none, 0);
  EXPECT_TRUE(none.empty());
}

}  // namespace
}  // namespace culld::testing
