#include "culling/scene/mesh.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "tests/unit/scene/test_meshes.h"

namespace culld {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

/// Every partner must be the same edge the other way round, and know of it.
void expectSoundPartners(const Mesh& mesh) {
  ASSERT_EQ(mesh.partners.size(), mesh.triangles.size() * 3);
  const auto from = [&](std::uint32_t h) { return mesh.triangles[h / 3][h % 3]; };
  const auto to = [&](std::uint32_t h) { return mesh.triangles[h / 3][(h % 3 + 1) % 3]; };
  for (std::uint32_t h = 0; h < mesh.partners.size(); ++h) {
    const std::uint32_t p = mesh.partners[h];
    if (p == kOpenEdge) continue;
    ASSERT_LT(p, mesh.partners.size());
    EXPECT_EQ(mesh.partners[p], h);
    EXPECT_EQ(from(p), to(h));
    EXPECT_EQ(to(p), from(h));
  }
}

std::size_t openEdges(const Mesh& mesh) {
  return static_cast<std::size_t>(
      std::count(mesh.partners.begin(), mesh.partners.end(), kOpenEdge));
}

TEST(Mesh, WeldsTheSidesOfACubeAndClosesIt) {
  const Mesh mesh = makeMesh({test::unitCube()});
  EXPECT_EQ(mesh.positions.size(), 8U);
  EXPECT_EQ(mesh.triangles.size(), 12U);
  EXPECT_EQ(openEdges(mesh), 0U);
  EXPECT_EQ(mesh.bounds, (Box{glm::dvec3(0.0), glm::dvec3(1.0)}));
  EXPECT_FALSE(mesh.unbounded);
  expectSoundPartners(mesh);
}

TEST(Mesh, KeepsTheWindingOfEveryTriangle) {
  const Mesh mesh = makeMesh({test::unitCube()});
  for (const auto& t : mesh.triangles) {
    const glm::dvec3 a(mesh.positions[t[0]]), b(mesh.positions[t[1]]), c(mesh.positions[t[2]]);
    const glm::dvec3 u = b - a, v = c - a, outwards = (a + b + c) / 3.0 - glm::dvec3(0.5);
    const glm::dvec3 normal{u.y * v.z - u.z * v.y, u.z * v.x - u.x * v.z, u.x * v.y - u.y * v.x};
    EXPECT_GT(normal.x * outwards.x + normal.y * outwards.y + normal.z * outwards.z, 0.0);
  }
}

TEST(Mesh, TakesMinusZeroAndZeroForOneVertex) {
  RawSurface raw;
  raw.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-0.0F, 0, -0.0F}, {0, 1, 0}, {-1, 0, 0}};
  raw.indices = {0, 1, 2, 3, 4, 5};
  const Mesh mesh = makeMesh({raw});
  EXPECT_EQ(mesh.positions.size(), 4U);
  EXPECT_EQ(openEdges(mesh), 4U);
  expectSoundPartners(mesh);
}

TEST(Mesh, DoesNotWeldNeighbouringFloats) {
  RawSurface raw;
  const float next = std::nextafter(1.0F, 2.0F);
  raw.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {next, 0, 0}, {0, 0, 0}, {0, -1, 0}};
  raw.indices = {0, 1, 2, 3, 4, 5};
  const Mesh mesh = makeMesh({raw});
  EXPECT_EQ(mesh.positions.size(), 5U);
  EXPECT_EQ(openEdges(mesh), 6U);
}

TEST(Mesh, DropsAndCountsTrianglesThatAreNoTriangles) {
  RawSurface raw;
  raw.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {kNan, 0, 0}, {9, 9, 9}};
  raw.indices = {0, 1, 2, 0, 3, 1, 0, 1, 4, 4, 1, 2, 1, 1, 2};
  const Mesh mesh = makeMesh({raw});
  EXPECT_EQ(mesh.triangles.size(), 1U);
  EXPECT_EQ(mesh.dropped_triangles, 4U);
  EXPECT_EQ(mesh.non_finite_vertices, 1U);
  EXPECT_TRUE(mesh.unbounded);
  EXPECT_EQ(mesh.bounds.max, glm::dvec3(1, 1, 0)) << "a vertex that no triangle uses counts not";
}

TEST(Mesh, ANonFiniteVertexThatNobodyUsesDoesNoHarm) {
  RawSurface raw;
  raw.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, std::numeric_limits<float>::infinity(), 0}};
  raw.indices = {0, 1, 2};
  EXPECT_FALSE(makeMesh({raw}).unbounded);
}

TEST(Mesh, LeavesEdgesThatRunTheSameWayOpen) {
  RawSurface raw;  // the second triangle is turned over: both run 0 -> 1
  raw.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  raw.indices = {0, 1, 2, 0, 1, 3};
  EXPECT_EQ(openEdges(makeMesh({raw})), 6U);
}

TEST(Mesh, PairsTwoAndLeavesTheThirdWhereThreeSheetsMeet) {
  RawSurface raw;
  raw.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}};
  raw.indices = {0, 1, 2, 1, 0, 3, 1, 0, 4};
  const Mesh mesh = makeMesh({raw});
  EXPECT_EQ(openEdges(mesh), 7U);
  EXPECT_EQ(mesh.partners[0], 3U) << "the first in order, always";
  expectSoundPartners(mesh);
}

TEST(Mesh, PairsAWallWithTheWallRatherThanWithGlass) {
  RawSurface wall, glass;
  wall.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, -1, 0}};
  glass.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}};
  glass.indices = {1, 0, 2};
  glass.blocks = false;
  wall.indices = {0, 1, 2, 1, 0, 3};
  const Mesh mesh = makeMesh({glass, wall});
  ASSERT_EQ(mesh.surfaces.size(), 2U);
  EXPECT_EQ(mesh.partners[3], 6U);
  EXPECT_EQ(mesh.partners[0], kOpenEdge);
  expectSoundPartners(mesh);
}

TEST(Mesh, SurfacesCoverTheTrianglesInOrderAndAlikeNeighboursAreOne) {
  RawSurface opaque = test::unitCube(), glass = test::unitCube();
  glass.blocks = false;
  const Mesh mesh = makeMesh({opaque, opaque, glass, RawSurface{}, opaque});
  ASSERT_EQ(mesh.surfaces.size(), 3U);
  std::uint32_t next = 0;
  for (const Surface& s : mesh.surfaces) {
    EXPECT_EQ(s.first_triangle, next);
    next += s.triangle_count;
  }
  EXPECT_EQ(next, mesh.triangles.size());
  EXPECT_EQ(mesh.surfaces[0].triangle_count, 24U);
  EXPECT_FALSE(mesh.surfaces[1].blocks);
  EXPECT_EQ(mesh.blocking_triangles, 36U);
  expectSoundPartners(mesh);
}

TEST(Mesh, OfNothingIsEmptyAndHasNoBounds) {
  const Mesh mesh = makeMesh({});
  EXPECT_TRUE(mesh.triangles.empty());
  EXPECT_TRUE(mesh.bounds.empty());
}

TEST(Mesh, PairsSoundlyOnRandomTrianglesWithManyMeetings) {
  std::mt19937 random(7);
  std::uniform_int_distribution<std::uint32_t> pick(0, 11);
  for (int round = 0; round < 50; ++round) {
    RawSurface raw;
    for (int i = 0; i < 12; ++i) raw.positions.emplace_back(i % 3, i / 3, i % 2);
    for (int i = 0; i < 300; ++i) raw.indices.push_back(pick(random));
    expectSoundPartners(makeMesh({raw}));
  }
}

}  // namespace
}  // namespace culld
