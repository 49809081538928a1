#include "culling/spatial/triangle_voxels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "tests/scenes/rounds.h"

namespace culld {
namespace {

using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

glm::dvec3 pointIn(Random& random, const Box& box) {
  return {uniform(random, box.min.x, box.max.x), uniform(random, box.min.y, box.max.y),
          uniform(random, box.min.z, box.max.z)};
}

/// Triangles that pass through one point of the box, which may lie within ulps of its rim: slivers,
/// huge ones, such that lie in planes of the axes, and such that only their tip reaches in.
TEST(TriangleVoxelsAttack, WhatReachesInsideABoxIsNeverClearOfIt) {
  Random random(11);
  for (std::uint64_t i = 0; i < scenes::rounds(400'000); ++i) {
    const double size = std::exp2(uniform(random, -20, 10)),
                 far = std::exp2(uniform(random, -5, 24));
    const glm::dvec3 corner = pointIn(random, {glm::dvec3(-far), glm::dvec3(far)});
    const Box box{corner, corner + glm::dvec3(size * uniform(random, 0.01, 1.0), size,
                                              size * uniform(random, 0.01, 1.0))};
    if (!(box.min.x < box.max.x && box.min.y < box.max.y && box.min.z < box.max.z)) continue;
    glm::dvec3 p = pointIn(random, box);
    for (int a = 0; a < 3; ++a) {
      if (random() % 3 == 0)
        p[a] = random() % 2 == 0 ? std::nextafter(box.min[a], box.max[a])
                                 : std::nextafter(box.max[a], box.min[a]);
      if (!(p[a] > box.min[a] && p[a] < box.max[a])) p[a] = 0.5 * box.min[a] + 0.5 * box.max[a];
    }
    if (!(p.x > box.min.x && p.x < box.max.x && p.y > box.min.y && p.y < box.max.y &&
          p.z > box.min.z && p.z < box.max.z)) {
      continue;
    }
    const double reach = size * std::exp2(uniform(random, -4, 12));
    WorldTriangle t;
    t[0] = p;  // the corner reaches in: a point of the triangle that nothing has rounded
    t[1] = p + pointIn(random, {glm::dvec3(-reach), glm::dvec3(reach)});
    t[2] = random() % 3 == 0 ? t[1] + 1e-9 * (t[1] - p)
                             : p + pointIn(random, {glm::dvec3(-reach), glm::dvec3(reach)});
    if (random() % 4 == 0) {
      const int axis = static_cast<int>(random() % 3);
      t[1][axis] = t[2][axis] = p[axis];
    }
    std::swap(t[0], t[random() % 3]);
    EXPECT_FALSE(clearOfInside(t, box));
  }
}

/// The point lies amid the triangle, on an edge or in its area. It is computed, so it counts only
/// if it is well inside.
TEST(TriangleVoxelsAttack, NeitherAreEdgesAndAreasThatPassThrough) {
  Random random(12);
  const Box box{glm::dvec3(-1.0), glm::dvec3(1.0)};
  for (std::uint64_t i = 0; i < scenes::rounds(400'000); ++i) {
    const double reach = std::exp2(uniform(random, -2, 30));
    const Box around{glm::dvec3(-reach), glm::dvec3(reach)};
    const glm::dvec3 p = pointIn(random, {glm::dvec3(-1.0 + 1e-6), glm::dvec3(1.0 - 1e-6)});
    // Ends on both sides of p, the third corner anywhere, or across from a point of that edge.
    const glm::dvec3 along = pointIn(random, around);
    const double back = uniform(random, 0.0, 1.0) * std::min(1.0, 1e9 / reach);
    WorldTriangle t{p + along, p - back * along, pointIn(random, around)};
    if (reach > 1e5) continue;
    EXPECT_FALSE(clearOfInside(t, box));
  }
}

TEST(TriangleVoxels, AWallInThePlaneOfAFaceIsClearOnBothSides) {
  const WorldTriangle wall{{{1.0, -5, -5}, {1.0, 9, -5}, {1.0, -5, 9}}};
  EXPECT_TRUE(clearOfInside(wall, {{0, 0, 0}, {1, 1, 1}}));
  EXPECT_TRUE(clearOfInside(wall, {{1, 0, 0}, {2, 1, 1}}));
  EXPECT_FALSE(clearOfInside(wall, {{0, 0, 0}, {std::nextafter(1.0, 2.0), 1, 1}}));
}

std::vector<double> steps(int count) {
  std::vector<double> out;
  for (int i = 0; i <= count; ++i) out.push_back(i);
  return out;
}

TEST(TriangleVoxels, MarksAreThoseThatTheTriangleReachesAndFewMore) {
  Random random(13);
  const VoxelGrid grid({steps(32), steps(32), steps(32)});
  const Box all = grid.boundsOf(grid.all());
  for (int i = 0; i < 60; ++i) {
    const WorldTriangle t{pointIn(random, all), pointIn(random, all), pointIn(random, all)};
    VoxelBits bits(grid.counts());
    const std::uint64_t tested = markVoxels(t, grid, grid.all(), bits);
    VoxelBits sampled(grid.counts());
    for (int k = 0; k < 20'000; ++k) {
      double a = uniform(random, 0, 1), b = uniform(random, 0, 1);
      if (a + b > 1) a = 1 - a, b = 1 - b;
      const glm::dvec3 p = t[0] + a * (t[1] - t[0]) + b * (t[2] - t[0]);
      sampled.set({static_cast<std::uint32_t>(p.x), static_cast<std::uint32_t>(p.y),
                   static_cast<std::uint32_t>(p.z)});
    }
    const std::uint64_t found = sampled.count();
    sampled.subtract(bits);
    EXPECT_EQ(sampled.count(), 0U);
    EXPECT_LE(bits.count(), found + found / 4 + 40);  // corners that samples seldom hit
    EXPECT_LE(tested, 40 * bits.count() + 100);
  }
}

TEST(TriangleVoxels, BitsAreCountedFromTheRange) {
  const VoxelGrid grid({steps(8), steps(8), steps(8)});
  VoxelBits bits({3, 3, 3});
  markVoxels({{{4.5, 4.5, 4.5}, {4.6, 4.5, 4.5}, {4.5, 4.6, 4.6}}}, grid, {{3, 4, 2}, {6, 7, 5}},
             bits);
  EXPECT_EQ(bits.count(), 1U);
  EXPECT_TRUE(bits.test({1, 0, 2}));
}

}  // namespace
}  // namespace culld
