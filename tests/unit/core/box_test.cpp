#include "culling/core/box.h"

#include <gtest/gtest.h>

namespace culld {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();
const double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(Box, IsEmptyUntilAPointGoesIn) {
  Box box;
  EXPECT_TRUE(box.empty());
  EXPECT_FALSE(box.finite());
  box.grow(glm::dvec3(1, 2, 3));
  EXPECT_FALSE(box.empty());
  EXPECT_TRUE(box.finite());
  EXPECT_EQ(box.min, box.max);
}

TEST(Box, GrowsToHoldPointsAndBoxes) {
  Box box;
  box.grow(glm::dvec3(1, -2, 3));
  box.grow(glm::dvec3(-1, 2, 0));
  EXPECT_EQ(box, (Box{{-1, -2, 0}, {1, 2, 3}}));
  box.grow(Box{{5, 0, 0}, {6, 1, 1}});
  EXPECT_EQ(box, (Box{{-1, -2, 0}, {6, 2, 3}}));
}

TEST(Box, DoesNotChangeByAnEmptyBox) {
  Box box{{0, 0, 0}, {1, 1, 1}};
  box.grow(Box{});
  EXPECT_EQ(box, (Box{{0, 0, 0}, {1, 1, 1}}));
}

TEST(Box, IsEmptyWithNaNInAnyPlace) {
  for (int axis = 0; axis < 3; ++axis) {
    Box low{{0, 0, 0}, {1, 1, 1}}, high = low;
    low.min[axis] = kNaN;
    high.max[axis] = kNaN;
    EXPECT_TRUE(low.empty());
    EXPECT_TRUE(high.empty());
    EXPECT_FALSE(low.finite());
  }
}

TEST(Box, IsNotFiniteWhenItReachesToInfinity) {
  const Box box{{-kInf, 0, 0}, {1, 1, 1}};
  EXPECT_FALSE(box.empty());
  EXPECT_FALSE(box.finite());
}

}  // namespace
}  // namespace culld
