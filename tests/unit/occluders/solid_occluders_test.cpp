#include "culling/occluders/solid_occluders.h"

#include <gtest/gtest.h>

#include "culling/scene/scene_builder.h"
#include "tests/scenes/model.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

class SolidOccludersTest : public ::testing::Test {
 protected:
  ObjectId add(const scenes::Triangles& t, const glm::dvec3& at = glm::dvec3(0.0)) {
    return builder_.addInstance(builder_.addMesh(makeMesh({{t.positions, t.indices, true, false}})),
                                scenes::movedBy(at), nodes_++);
  }
  SolidOccluders bake() {
    scene_ = builder_.finish();
    return SolidOccluders::of(*scene_, {}).value();
  }
  static Box at(const glm::dvec3& p, double by = 0.0) {
    return {p - glm::dvec3(by), p + glm::dvec3(by)};
  }

  SceneBuilder builder_;
  SnapshotPtr scene_;
  std::uint32_t nodes_ = 0;
};

TEST_F(SolidOccludersTest, BoxesLieWithinTheirWallsAndNearlyFillThem) {
  add(scenes::box({-5, 0, -0.1F}, {5, 3, 0.1F}));
  const SolidOccluders solids = bake();
  ASSERT_EQ(solids.size(), 1U);
  const Box box = solids.box(0);
  const Box wall = scene_->mesh(0).bounds;
  for (int a = 0; a < 3; ++a) {
    EXPECT_GT(box.min[a], wall.min[a]);
    EXPECT_LT(box.max[a], wall.max[a]);
    EXPECT_NEAR(box.min[a], wall.min[a], 1e-9);
  }
  const Box drawn = solids.drawn().scene()->instance(0).bounds_world;
  EXPECT_GE(drawn.min.z, wall.min.z);
  EXPECT_LE(drawn.max.x, wall.max.x);
  EXPECT_GT(solids.bytes(), 0U);
}

TEST_F(SolidOccludersTest, AnEyeIsClearOutsideOfAllThatTheBoxesStandFor) {
  add(scenes::box({-5, 0, -0.1F}, {5, 3, 0.1F}));
  const SolidOccluders solids = bake();
  EXPECT_TRUE(solids.clear(at({0, 1, 2})));
  EXPECT_TRUE(solids.clear(at({0, 1, 1000})));
  EXPECT_FALSE(solids.clear(at({0, 1, 0})));
  EXPECT_FALSE(solids.clear(at({0, 1, 0.1})));
  EXPECT_FALSE(solids.clear(at({0, 1, 1}, 0.95)));
  EXPECT_FALSE(solids.clear(at({0, 1, double{0.1F} + 1e-13})));  // the face may be so much off
  EXPECT_TRUE(solids.clear(at({0, 1, double{0.1F} + 1e-6})));
  EXPECT_FALSE(solids.clear(at(glm::dvec3(std::nan("")))));
}

TEST_F(SolidOccludersTest, WithoutAnObjectGoesAllThatRestedOnIt) {
  const ObjectId left = add(scenes::box({-5, 0, 0}, {0, 3, 0.2F}));
  const ObjectId right = add(scenes::box({0, 0, 0}, {5, 3, 0.2F}));
  const ObjectId far = add(scenes::box({0, 0, 0}, {5, 3, 0.2F}), {20, 0, 0});
  const ObjectId sheet = add(scenes::quad({0, 0, 5}, {1, 0, 0}, {0, 1, 0}));
  const SolidOccluders solids = bake();
  ASSERT_EQ(solids.size(), 2U);  // the first two are one
  const ObjectId none[] = {sheet};
  EXPECT_EQ(solids.without(none).value().size(), 2U);
  const ObjectId one[] = {right};
  const SolidOccluders rest = solids.without(one).value();
  ASSERT_EQ(rest.size(), 1U);
  EXPECT_NEAR(rest.box(0).min.x, 20.0, 1e-6);
  const ObjectId both[] = {left, far};
  EXPECT_EQ(solids.without(both).value().size(), 0U);
  EXPECT_EQ(rest.without(both).value().size(), 0U);
  EXPECT_FALSE(rest.clear(at({2, 1, 0.1})));  // stays on the safe side
}

TEST_F(SolidOccludersTest, ScenesWithoutAnythingClosedHaveNone) {
  EXPECT_EQ(bake().size(), 0U);
  add(scenes::quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}));
  const SolidOccluders solids = bake();
  EXPECT_EQ(solids.size(), 0U);
  EXPECT_TRUE(solids.clear(at(glm::dvec3(0.5))));
}

TEST_F(SolidOccludersTest, EqualScenesGiveEqualBoxes) {
  for (int i = 0; i < 30; ++i)
    add(scenes::box({0, 0, 0}, {1, 3, 0.25F}), {1.7 * i, 0.3 * i, i % 7});
  const SolidOccluders first = bake();
  const SolidOccluders second = SolidOccluders::of(*scene_, {}).value();
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first.box(i), second.box(i));
}

}  // namespace
}  // namespace culld
