#include "culling/scene/scene_snapshot.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/unit/scene/test_meshes.h"

namespace culld {
namespace {

using Rows = std::array<double, 12>;

bool contains(const Box& box, const glm::dvec3& p) {
  return box.min.x <= p.x && p.x <= box.max.x && box.min.y <= p.y && p.y <= box.max.y &&
         box.min.z <= p.z && p.z <= box.max.z;
}

Mesh randomTriangles(std::mt19937& random, float size) {
  std::uniform_real_distribution<float> coordinate(-size, size);
  RawSurface raw;
  for (std::uint32_t i = 0; i < 30; ++i) {
    raw.positions.emplace_back(coordinate(random), coordinate(random), coordinate(random));
    raw.indices.push_back(i);
  }
  return makeMesh({raw});
}

/// One world coordinate summed in every order that a program may use, with and without FMA.
std::vector<double> everyOrder(const double* m, const glm::dvec3& p) {
  const double a = m[0] * p.x, b = m[1] * p.y, c = m[2] * p.z, d = m[3];
  return {((a + b) + c) + d, d + (c + (b + a)), (a + b) + (c + d), (a + d) + (b + c),
          std::fma(m[0], p.x, std::fma(m[1], p.y, std::fma(m[2], p.z, d)))};
}

TEST(SceneSnapshot, BoundsContainEveryVertexInAnyOrderOfEvaluation) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> exponent(-6, 7), unit(-1, 1);
  for (int round = 0; round < 300; ++round) {
    Rows rows{};
    for (double& m : rows) m = unit(random) * std::pow(10.0, exponent(random));
    SceneBuilder builder;
    const MeshId mesh = builder.addMesh(
        randomTriangles(random, static_cast<float>(std::pow(10.0, exponent(random)))));
    builder.addInstance(mesh, rows, 0);
    const SnapshotPtr scene = builder.finish();
    const Instance& instance = scene->instance(0);
    ASSERT_FALSE(instance.always_kept);
    for (const glm::vec3& p : scene->mesh(mesh).positions) {
      for (int r = 0; r < 3; ++r) {
        for (const double w : everyOrder(&rows[static_cast<std::size_t>(4 * r)], glm::dvec3(p))) {
          EXPECT_LE(instance.bounds_world.min[r], w);
          EXPECT_GE(instance.bounds_world.max[r], w);
        }
      }
    }
  }
}

TEST(SceneSnapshot, BoundsAreTightUpToRounding) {
  const Box box = boundsOf({0, -2, 0, 1e6, 3, 0, 0, 0, 0, 0, 1, -5}, {{0, 0, 0}, {1, 1, 1}});
  EXPECT_TRUE(contains(box, {1e6 - 2, 0, -5}));
  EXPECT_TRUE(contains(box, {1e6, 3, -4}));
  EXPECT_NEAR(box.min.x, 1e6 - 2, 1e-8);
  EXPECT_NEAR(box.max.x, 1e6, 1e-8);
  EXPECT_NEAR(box.max.y, 3, 1e-14);
}

TEST(SceneSnapshot, AlwaysKeepsWhatHasNoBound) {
  const auto kept = [](const Rows& rows, bool unbounded) {
    SceneBuilder builder;
    Mesh mesh = makeMesh({test::unitCube()});
    mesh.unbounded = unbounded;
    builder.addInstance(builder.addMesh(std::move(mesh)), rows, 0);
    const SnapshotPtr scene = builder.finish();
    EXPECT_TRUE(scene->instance(0).active());
    return scene->instance(0).always_kept;
  };
  EXPECT_FALSE(kept(test::kIdentity, false));
  EXPECT_TRUE(kept(test::kIdentity, true));
  EXPECT_TRUE(kept(test::movedBy(std::numeric_limits<double>::quiet_NaN(), 0, 0), false));
  EXPECT_TRUE(kept(test::movedBy(0, std::numeric_limits<double>::infinity(), 0), false));
  EXPECT_TRUE(kept({1.7e308, 1.7e308, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, false)) << "overflow";
}

TEST(SceneSnapshot, AnObjectWithoutGeometryIsNeverActive) {
  SceneBuilder builder;
  builder.addInstance(builder.addMesh(makeMesh({})), test::kIdentity, 0);
  const SnapshotPtr scene = builder.finish();
  EXPECT_FALSE(scene->instance(0).active());
  EXPECT_FALSE(scene->instance(0).always_kept);
}

TEST(SceneSnapshot, EqualScenesHaveEqualHashesAndDifferentOnesNot) {
  const auto hash = [](float size, double x, std::uint32_t node, bool blocks) {
    SceneBuilder builder;
    RawSurface raw = test::unitCube();
    raw.blocks = blocks;
    for (glm::vec3& p : raw.positions) p *= size;
    builder.addInstance(builder.addMesh(makeMesh({raw})), test::movedBy(x, 0, 0), node);
    return builder.finish()->contentHash();
  };
  EXPECT_EQ(hash(1, 2, 3, true), hash(1, 2, 3, true));
  EXPECT_NE(hash(1, 2, 3, true), hash(1.5F, 2, 3, true));
  EXPECT_NE(hash(1, 2, 3, true), hash(1, 2.5, 3, true));
  EXPECT_NE(hash(1, 2, 3, true), hash(1, 2, 4, true));
  EXPECT_NE(hash(1, 2, 3, true), hash(1, 2, 3, false));
  EXPECT_EQ(hash(1, 0.0, 3, true), hash(1, -0.0, 3, true)) << "minus zero is no other place";
}

TEST(SceneSnapshot, ObjectsWithoutAFinitePlaceAreWarnedAboutByCount) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(makeMesh({test::unitCube()}));
  builder.addInstance(mesh, test::kIdentity, 0);
  builder.addInstance(mesh, test::movedBy(kNan, 0, 0), 7);
  const SnapshotPtr one = builder.finish();
  ASSERT_EQ(one->warnings().size(), 1U);
  EXPECT_EQ(one->warnings()[0], "node 7: its object's place is not finite; it is always kept");

  const MeshId again = builder.addMesh(makeMesh({test::unitCube()}));
  std::array<double, 12> overflows = test::kIdentity;
  overflows[0] = overflows[1] = overflows[2] = 1.5e308;  // finite, but its sums are not
  for (const std::uint32_t node : {4U, 5U}) builder.addInstance(again, overflows, node);
  builder.addInstance(again, test::movedBy(0, std::numeric_limits<double>::infinity(), 0), 6);
  const SnapshotPtr three = builder.finish();
  ASSERT_EQ(three->warnings().size(), 1U);
  EXPECT_EQ(
      three->warnings()[0],
      "node 4: its object's place is not finite, nor is that of 2 more; they are always kept");
  for (ObjectId id = 0; id < 3; ++id) EXPECT_TRUE(three->instance(id).always_kept);
}

TEST(SceneSnapshot, TheBuilderIsEmptyAfterwardsAndKeepsWarnings) {
  SceneBuilder builder;
  builder.addInstance(builder.addMesh(makeMesh({test::unitCube()})), test::kIdentity, 0);
  builder.warn("mesh 0: odd");
  const SnapshotPtr first = builder.finish(), second = builder.finish();
  EXPECT_EQ(first->objectCount(), 1U);
  EXPECT_EQ(first->triangleCount(), 12U);
  ASSERT_EQ(first->warnings().size(), 1U);
  EXPECT_EQ(first->warnings()[0], "mesh 0: odd");
  EXPECT_EQ(first->version(), 1U);
  EXPECT_EQ(second->objectCount(), 0U);
  EXPECT_EQ(second->meshCount(), 0U);
}

}  // namespace
}  // namespace culld
