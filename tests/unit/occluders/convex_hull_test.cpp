#include "culling/occluders/convex_hull.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

namespace culld {
namespace {

std::vector<glm::dvec3> cube(double half) {
  std::vector<glm::dvec3> points;
  for (unsigned i = 0; i < 8; ++i)
    points.emplace_back((i & 1) ? half : -half, (i & 2) ? half : -half, (i & 4) ? half : -half);
  return points;
}

/// How far the points stick out of the hull, at most.
double outside(const ConvexHull& hull, const std::vector<glm::dvec3>& points) {
  double most = -std::numeric_limits<double>::infinity();
  for (const auto& t : hull.triangles) {
    const glm::dvec3 a = points[t[0]], n = glm::cross(points[t[1]] - a, points[t[2]] - a);
    for (const glm::dvec3& p : points) most = std::max(most, glm::dot(p - a, n) / glm::length(n));
  }
  return most;
}

TEST(ConvexHull, OfACubeIsItsCornersAndTwelveTrianglesFacingOutwards) {
  std::vector<glm::dvec3> points = cube(1.0);
  points.emplace_back(0.0, 0.0, 0.0);   // inside
  points.emplace_back(1.0, 0.25, 0.0);  // on a face
  points.push_back(points[3]);          // twice
  const ConvexHull hull = convexHull(points);
  EXPECT_EQ(hull.corners.size(), 8U);
  EXPECT_EQ(hull.triangles.size(), 12U);
  EXPECT_LT(outside(hull, points), 1e-12);
}

TEST(ConvexHull, HoldsRandomPointsAtAnyPlaceAndScale) {
  std::mt19937_64 random(1);
  for (const double scale : {1e-30, 1.0, 1e12}) {
    std::vector<glm::dvec3> points;
    std::normal_distribution<double> normal;
    for (int i = 0; i < 500; ++i)
      points.push_back(scale * glm::dvec3(normal(random) + 9, normal(random), normal(random)));
    const ConvexHull hull = convexHull(points);
    ASSERT_FALSE(hull.empty()) << scale;
    EXPECT_LT(outside(hull, points), 1e-9 * scale);
    EXPECT_EQ(hull.triangles.size(), 2 * hull.corners.size() - 4);
  }
}

TEST(ConvexHull, ManyPointsInOnePlaneOfABodyDoNotHurt) {
  std::vector<glm::dvec3> points = cube(1.0);
  for (int i = 0; i < 40; ++i) {
    for (int j = 0; j < 40; ++j)
      points.emplace_back(i / 20.0 - 0.975, j / 20.0 - 0.975, 1.0 + 1e-16 * (i - j));
  }
  const ConvexHull hull = convexHull(points);
  ASSERT_FALSE(hull.empty());
  EXPECT_LT(outside(hull, points), 1e-9);
}

TEST(ConvexHull, FlatFewAndOddPointsHaveNone) {
  EXPECT_TRUE(convexHull({}).empty());
  const std::vector<glm::dvec3> one(9, glm::dvec3(1, 2, 3));
  EXPECT_TRUE(convexHull(one).empty());
  std::vector<glm::dvec3> flat, slanted, line;
  for (int i = 0; i < 20; ++i) {
    flat.emplace_back(i % 5, i / 5, 2.0);
    slanted.emplace_back(i % 5, i / 5, 0.3 * (i % 5) - 0.7 * (i / 5));
    line.emplace_back(i, 2 * i, 3 * i);
  }
  EXPECT_TRUE(convexHull(flat).empty());
  EXPECT_TRUE(convexHull(slanted).empty());
  EXPECT_TRUE(convexHull(line).empty());
  for (const double odd :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    std::vector<glm::dvec3> points = cube(1.0);
    points[5].y = odd;
    EXPECT_TRUE(convexHull(points).empty());
  }
}

}  // namespace
}  // namespace culld
