// The parts of `cullctl load` that count and compare.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include "client/cli/histogram.h"
#include "client/cli/motion.h"

namespace culld::client {
namespace {

TEST(Histogram, TellsQuantilesWithinTwoPercent) {
  Histogram histogram;
  std::vector<std::uint64_t> values;
  std::mt19937_64 random(7);
  std::lognormal_distribution<double> spread(13.0, 2.0);
  for (int i = 0; i < 20'000; ++i) {
    values.push_back(static_cast<std::uint64_t>(spread(random)));
    histogram.record(values.back());
  }
  std::sort(values.begin(), values.end());
  for (const double share : {0.01, 0.5, 0.9, 0.99, 0.999}) {
    const auto rank = static_cast<std::size_t>(std::ceil(share * 20'000.0)) - 1;
    const auto exact = static_cast<double>(values[rank]);
    EXPECT_NEAR(static_cast<double>(histogram.quantile(share)), exact, exact * 0.02) << share;
    EXPECT_GE(histogram.quantile(share), values[rank]);
  }
  EXPECT_EQ(histogram.max(), values.back());
  EXPECT_EQ(histogram.quantile(1.0), values.back());
}

TEST(Histogram, HoldsTheSmallestAndTheLargest) {
  Histogram histogram;
  EXPECT_EQ(histogram.quantile(0.5), 0U);
  for (const std::uint64_t value : {0ULL, 1ULL, 127ULL, 128ULL, ~0ULL}) {
    Histogram one;
    one.record(value);
    EXPECT_EQ(one.quantile(0.5), value);
    histogram.add(one);
  }
  EXPECT_EQ(histogram.count(), 5U);
  EXPECT_EQ(histogram.quantile(0.2), 0U);
  EXPECT_EQ(histogram.quantile(1.0), ~0ULL);
}

protocol::Camera lookingFrom(double x, double heading_rad) {
  protocol::LookAt look;
  look.eye = {x, 2, 3};
  look.target = {x + std::sin(heading_rad), 2, 3 - std::cos(heading_rad)};
  protocol::Camera camera;
  camera.pose = look;
  return camera;
}

TEST(MotionBound, EndsAtItsRadiusAndAtItsAngle) {
  const Pose centre = poseOf(lookingFrom(0, 0));
  EXPECT_TRUE(withinBound(centre, centre, 0, 0));
  EXPECT_TRUE(withinBound(poseOf(lookingFrom(0.99, 0)), centre, 1, 0));
  EXPECT_FALSE(withinBound(poseOf(lookingFrom(1.01, 0)), centre, 1, 0));
  EXPECT_TRUE(withinBound(poseOf(lookingFrom(0, 0.29)), centre, 1, 0.3));
  EXPECT_FALSE(withinBound(poseOf(lookingFrom(0, 0.31)), centre, 1, 0.3));
}

TEST(MotionBound, IsTheSameForMatrices) {
  // The inverse of: turned by 90 degrees to the left, then moved to (5, 6, 7).
  protocol::Matrices matrices;
  matrices.view = {0, 0, 1, 0, 0, 1, 0, 0, -1, 0, 0, 0, 7, -6, -5, 1};
  protocol::Camera camera;
  camera.pose = matrices;
  const Pose pose = poseOf(camera);
  EXPECT_EQ(pose.eye, (std::array<double, 3>{5, 6, 7}));
  protocol::LookAt look;
  look.eye = {5, 6, 7};
  look.target = {5 - 1, 6, 7};
  camera.pose = look;
  EXPECT_TRUE(withinBound(pose, poseOf(camera), 0, 0));
}

}  // namespace
}  // namespace culld::client
