#include "culling/methods/occluder_volumes.h"

#include <gtest/gtest.h>

#include "culling/methods/frustum.h"
#include "culling/scene/edit.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

using scenes::Triangles;

/// A wall across the view at z = 0, small things behind it, and what each test adds.
class BehindAWall : public ::testing::Test {
 protected:
  BehindAWall() {
    wall_ = addMesh(scenes::box({-20, -10, -0.5F}, {20, 10, 0.5F}));
    thing_ = addMesh(scenes::box(glm::vec3(-0.2F), glm::vec3(0.2F)));
    for (int i = 0; i < 900; ++i)
      addThing({i % 30 - 14.5, (i / 30) % 30 * 0.5 - 7.0, -20.0 - i % 7});
  }

  MeshId addMesh(const Triangles& t) {
    return builder_.addMesh(makeMesh({{t.positions, t.indices, true, false}}));
  }
  ObjectId add(MeshId mesh, const scenes::Rows& rows) {
    return builder_.addInstance(mesh, rows, nodes_++);
  }
  ObjectId addThing(const glm::dvec3& at) { return add(thing_, scenes::movedBy(at)); }
  void finish() { scene_ = builder_.finish(); }

  static Camera camera(MotionBound motion = {}) {
    LookAt look;
    look.eye = {0, 0, 30};
    look.target = {0, 0, 0};
    return cameraFromLookAt(look, {}, motion).value();
  }

  Answer cull(const std::string& settings = "", const Camera& seen_by = camera()) {
    ConfiguredMethods methods(allMethods());
    const auto method = methods.find("occluder-volumes" + settings);
    EXPECT_TRUE(method.ok()) << settings;
    const auto culler = method.value()->prepare(scene_);
    EXPECT_TRUE(culler.ok());
    ViewState view;
    return culler.value()->cull(seen_by, {}, view);
  }

  SceneBuilder builder_;
  std::uint32_t nodes_ = 0;
  MeshId wall_ = 0, thing_ = 0;
  SnapshotPtr scene_;
};

TEST_F(BehindAWall, ThingsAreLeftOutByWholeNodes) {
  const ObjectId wall = add(wall_, scenes::kIdentity);
  finish();
  const Answer answer = cull();
  EXPECT_EQ(answer.visible, std::vector<ObjectId>{wall});
  EXPECT_EQ(answer.stats.occluders_drawn, 1U);
  EXPECT_EQ(answer.stats.in_frustum, 901U);
  EXPECT_LT(answer.stats.tested, 400U);
  EXPECT_TRUE(answer.note.empty());
}

TEST_F(BehindAWall, HidesFromAMovingAndTurningCamera) {
  const ObjectId wall = add(wall_, scenes::kIdentity);
  finish();
  EXPECT_EQ(cull("", camera({1.0, 1.0})).visible, std::vector<ObjectId>{wall});
  EXPECT_GT(cull("", camera({25.0, 0.0})).visible.size(), 100U);  // around the wall's end
  EXPECT_EQ(cull("", camera({40.0, 0.0})).visible.size(), 901U);  // beyond the wall
}

TEST_F(BehindAWall, OccludersThatALargerOneHidesMakeNoVolume) {
  add(wall_, scenes::kIdentity);
  for (int i = 0; i < 4; ++i) add(wall_, scenes::scaledAndMoved({0.5, 0.5, 1}, {0, 0, -8.0 - i}));
  finish();
  EXPECT_EQ(cull().stats.occluders_drawn, 1U);
  EXPECT_EQ(cull(":drop-hidden=off").stats.occluders_drawn, 5U);
  EXPECT_EQ(cull(":drop-hidden=off").visible, cull().visible);
}

TEST_F(BehindAWall, SmallOccludersMakeNoVolume) {
  finish();
  EXPECT_EQ(cull().stats.occluders_drawn, 0U);
  EXPECT_GT(cull(":least-share=0").stats.occluders_drawn, 0U);
}

TEST_F(BehindAWall, NoMoreVolumesThanAsked) {
  for (int i = 0; i < 6; ++i)
    add(wall_, scenes::scaledAndMoved({0.1, 0.5, 1}, {5.0 * i - 12.5, 0, 0}));
  finish();
  EXPECT_EQ(cull().stats.occluders_drawn, 6U);
  const Answer two = cull(":volumes=2");
  EXPECT_EQ(two.stats.occluders_drawn, 2U);
  EXPECT_GT(two.visible.size(), cull().visible.size());
}

TEST_F(BehindAWall, TheSphereSavesComparisons) {
  add(wall_, scenes::kIdentity);
  add(wall_, scenes::scaledAndMoved({0.2, 0.5, 1}, {-8, 0, 12}));
  add(wall_, scenes::scaledAndMoved({0.2, 0.5, 1}, {8, 0, 12}));
  finish();
  const Answer with = cull(), without = cull(":sphere=off");
  EXPECT_EQ(with.visible, without.visible);
  EXPECT_LT(with.stats.plane_tests, without.stats.plane_tests);
}

TEST_F(BehindAWall, OneFacingPlaneSavesComparisonsAndLosesNearTheOccluder) {
  add(addMesh(scenes::prism(scenes::regularFootprint(12, 6.0F), -9.0F, 9.0F)), scenes::kIdentity);
  const ObjectId inside = addThing({0, 0, 5.0});
  finish();
  const Answer with = cull(), without = cull(":collapse=off");
  EXPECT_LT(with.stats.plane_tests, without.stats.plane_tests);
  EXPECT_TRUE(std::binary_search(with.visible.begin(), with.visible.end(), inside));
  EXPECT_FALSE(std::binary_search(without.visible.begin(), without.visible.end(), inside));
}

TEST_F(BehindAWall, TurnedThingsAreAskedByTheirOwnBox) {
  add(wall_, scenes::kIdentity);
  const MeshId slab = addMesh(scenes::box({-14, -1, -0.1F}, {14, 1, 0.1F}));
  const ObjectId turned = add(slab, scenes::turnedAndMoved(0.75, {12, 0, -12}));
  finish();
  const Answer with = cull(), without = cull(":oriented=off");
  EXPECT_FALSE(std::binary_search(with.visible.begin(), with.visible.end(), turned));
  EXPECT_TRUE(std::binary_search(without.visible.begin(), without.visible.end(), turned));
}

TEST_F(BehindAWall, AConcaveHouseHidesByAHullWithinIt) {
  const std::vector<glm::vec2> corner{{-20, -1}, {-20, 1}, {19, 1}, {19, 8}, {20, 8}, {20, -1}};
  const MeshId house = addMesh(scenes::prism(corner, -10.0F, 10.0F, 5));
  const ObjectId id = add(house, scenes::kIdentity);
  finish();
  EXPECT_EQ(cull().visible, std::vector<ObjectId>{id});
  EXPECT_EQ(cull(":hulls=off").visible.size(), 901U);
}

TEST_F(BehindAWall, AnEditedOccluderHidesWhereItStandsNow) {
  const ObjectId wall = add(wall_, scenes::kIdentity);
  finish();
  const auto before = occluderVolumesMethod().prepare(scene_);
  ASSERT_TRUE(before.ok());
  ViewState view;
  EXPECT_EQ(before.value()->cull(camera(), {}, view).visible.size(), 1U);
  const std::vector<Edit> edits{MoveObject{wall, scenes::movedBy({60, 0, 0})}};
  const auto edited = applyEdits(scene_, edits);
  ASSERT_TRUE(edited.ok());
  const auto after = before.value()->edited(edited.value().snapshot, edited.value().changed);
  ASSERT_TRUE(after.ok());
  view.sceneEdited();
  const auto frustum = frustumMethod().prepare(edited.value().snapshot);
  ViewState other;
  EXPECT_EQ(after.value()->cull(camera(), {}, view).visible,
            frustum.value()->cull(camera(), {}, other).visible);
  EXPECT_EQ(before.value()->cull(camera(), {}, view).visible.size(), 1U);
}

TEST_F(BehindAWall, SaysWhyOcclusionIsLeftOut) {
  add(wall_, scenes::kIdentity);
  finish();
  glm::dmat4 parallel(0.05);
  parallel[2][2] = -0.01;
  parallel[3][3] = 1.0;
  glm::dmat4 view(1.0);
  view[3][2] = -30.0;
  const auto still = cameraFromMatrices(view, parallel, {});
  const auto turning = cameraFromMatrices(view, parallel, {}, {0.0, 0.1});
  ASSERT_TRUE(still.ok() && turning.ok());
  EXPECT_EQ(cull("", still.value()).visible.size(), 1U);
  const Answer answer = cull("", turning.value());
  EXPECT_EQ(answer.visible.size(), 901U);
  EXPECT_NE(answer.note.find("orthographic camera that turns"), std::string::npos);
}

}  // namespace
}  // namespace culld
