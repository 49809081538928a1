// How much the oracle says it may have missed, against what many more rays then find.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <span>

#include "culling/oracle/oracle.h"
#include "tests/scenes/city.h"
#include "tests/scenes/random_scene.h"

namespace culld {
namespace {

TEST(UnfoundEstimate, GrowsWithWhatOnlyOneTryFound) {
  const UnfoundEstimate estimate{.tries = 4, .found_once = 6, .not_found = 100};
  EXPECT_DOUBLE_EQ(estimate.byOneMoreTry(), 1.5);
  EXPECT_DOUBLE_EQ(estimate.byAnyNumber(), 12.0);
}

TEST(UnfoundEstimate, NeverExceedsWhatWasNotFound) {
  const UnfoundEstimate estimate{.tries = 4, .found_once = 600, .not_found = 3};
  EXPECT_DOUBLE_EQ(estimate.byOneMoreTry(), 3.0);
  EXPECT_DOUBLE_EQ(estimate.byAnyNumber(), 3.0);
}

TEST(UnfoundEstimate, IsNothingWithoutTries) {
  const UnfoundEstimate estimate{.tries = 0, .found_once = 9, .not_found = 50};
  EXPECT_EQ(estimate.byOneMoreTry(), 0.0);
  EXPECT_EQ(estimate.byAnyNumber(), 0.0);
}

constexpr std::uint32_t kMany = 512;  ///< rays at each object: as good as forever
constexpr std::array<std::uint32_t, 3> kFew = {8, 16, 32};

/// What few rays expect and what more rays then find, summed over cameras.
struct Expected {
  double one_more = 0.0, any_number = 0.0;
  std::size_t visible = 0, next_found = 0, found_at_last = 0;
};
using Sums = std::array<Expected, kFew.size()>;  // as kFew

OracleAnswer lookWith(const Oracle& oracle, const Camera& camera, OracleOptions options,
                      std::uint32_t rays) {
  options.rays_per_object = rays;
  return oracle.look(camera, options).value();
}

/// Rounds depend on their number only: with more rays, the first ones are the same.
void expectAndFind(const SnapshotPtr& scene, std::span<const scenes::CameraSpec> cameras,
                   const OracleOptions& options, Sums& sums) {
  const auto oracle = Oracle::build(scene);
  ASSERT_TRUE(oracle.ok());
  for (const scenes::CameraSpec& spec : cameras) {
    const Camera camera = scenes::toCamera(spec).value();
    const std::size_t at_last = lookWith(*oracle.value(), camera, options, kMany).visible.size();
    for (std::size_t i = 0; i < kFew.size(); ++i) {
      const OracleAnswer few = lookWith(*oracle.value(), camera, options, kFew[i]);
      const OracleAnswer next =
          lookWith(*oracle.value(), camera, options, kFew[i] + kAimedRaysPerRound);
      Expected& sum = sums[i];
      sum.visible += few.visible.size();
      sum.one_more += few.unfound_by_rays.byOneMoreTry();
      sum.any_number += few.unfound_by_rays.byAnyNumber();
      sum.next_found += next.visible.size() - few.visible.size();
      sum.found_at_last += at_last - few.visible.size();
    }
  }
}

/// Both as good as counts of this size can be.
void expectForeseen(const char* what, const Sums& sums) {
  for (std::size_t i = 0; i < kFew.size(); ++i) {
    const Expected& sum = sums[i];
    std::printf(
        "%s, %2u rays: %zu visible; one more round: %.1f expected, %zu found; "
        "any number: %.1f expected, %zu found by %u rays\n",
        what, kFew[i], sum.visible, sum.one_more, sum.next_found, sum.any_number, sum.found_at_last,
        kMany);
    const double next = static_cast<double>(sum.next_found);
    const double last = static_cast<double>(sum.found_at_last);
    EXPECT_NEAR(sum.one_more, next, 2.5 * std::sqrt(next) + 2.0);
    EXPECT_GT(sum.any_number, last / 3.0);
    EXPECT_LT(sum.any_number, last * 3.0);
    EXPECT_GT(last, 5.0);
  }
}

TEST(UnfoundEstimate, ForeseesWhatFurtherRaysFindInRandomScenes) {
  Sums sums;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SnapshotPtr scene = scenes::randomScene(seed, {.objects = 150});
    // Few samples, so that aimed rays have much to find.
    expectAndFind(scene, scenes::randomCameras(seed, *scene, 3), {.max_samples = 400, .seed = seed},
                  sums);
  }
  expectForeseen("random scenes", sums);
}

TEST(UnfoundEstimate, ForeseesWhatFurtherRaysFindInACity) {
  const scenes::City city = scenes::generateCity({.seed = 2, .objects = 3'000, .frames = 5});
  Sums sums;
  expectAndFind(scenes::toSnapshot(city.model), city.cameras, {.max_samples = 2'000}, sums);
  expectForeseen("city", sums);
}

}  // namespace
}  // namespace culld
