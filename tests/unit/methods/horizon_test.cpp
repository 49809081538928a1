#include "culling/methods/horizon.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "culling/methods/frustum.h"
#include "culling/scene/edit.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

scenes::Triangles house(float height) {
  return scenes::box(glm::vec3(-4, 0, -4), glm::vec3(4, height, 4));
}

/// Streets of houses between x = -100 and 100, rows going away from z = 0.
SnapshotPtr town(int rows) {
  SceneBuilder builder;
  std::uint32_t node = 0;
  for (int row = 0; row < rows; ++row) {
    const scenes::Triangles of = house(10.0F);
    const MeshId mesh = builder.addMesh(makeMesh({{of.positions, of.indices, true, false}}));
    for (int i = -12; i <= 12; ++i) {
      std::array<double, 12> at = scenes::kIdentity;
      at[3] = 8.5 * i;
      at[11] = -14.0 * row - 20.0;
      builder.addInstance(mesh, at, node++);
    }
  }
  return builder.finish();
}

Camera inTheStreet(double side = 0.0) {
  LookAt look;
  look.eye = {side, 1.7, 0.0};
  look.target = {0.6 * side, 1.7, -50.0};
  return cameraFromLookAt(look, {}).value();
}

Answer answerOf(const std::string& name, const SnapshotPtr& scene, const Camera& camera,
                const Demand& demand = {}) {
  ConfiguredMethods methods(allMethods());
  const auto method = methods.find(name);
  EXPECT_TRUE(method.ok()) << name;
  const auto culler = method.value()->prepare(scene);
  ViewState view;
  return culler.value()->cull(camera, demand, view);
}

TEST(HorizonMethod, LeavesOutTheStreetsBehindTheFirst) {
  const SnapshotPtr scene = town(12);
  const Answer answer = answerOf("horizon", scene, inTheStreet());
  const Answer frustum = answerOf("frustum", scene, inTheStreet());
  EXPECT_LT(3 * answer.visible.size(), frustum.visible.size());
  EXPECT_EQ(answer.stats.in_frustum, frustum.stats.in_frustum);
  EXPECT_EQ(answer.guarantee, Guarantee::kConservative);
}

TEST(HorizonMethod, HidesMoreWithTheSweep) {
  const SnapshotPtr scene = town(12);
  const auto answered = [&](const char* name) {
    return answerOf(name, scene, inTheStreet(40)).visible.size();
  };
  EXPECT_LT(answered("horizon"), answered("horizon:sweep=off"));
}

TEST(HorizonMethod, EndsAtNodesBehindTheHorizonAndNotWithoutTheHierarchy) {
  const SnapshotPtr scene = town(40);
  const Answer with = answerOf("horizon", scene, inTheStreet());
  const Answer without = answerOf("horizon:hierarchy=off", scene, inTheStreet());
  EXPECT_EQ(with.visible, without.visible);
  EXPECT_LT(2 * with.stats.tested, without.stats.tested);
}

TEST(HorizonMethod, LooksAtFewerColumnsWithTheTree) {
  const SnapshotPtr scene = town(12);
  const Answer with = answerOf("horizon", scene, inTheStreet());
  const Answer without = answerOf("horizon:tree=off", scene, inTheStreet());
  EXPECT_EQ(with.visible, without.visible);
  EXPECT_LT(with.stats.work, without.stats.work);
}

/// One long wall that runs away beside the street, and houses behind it all along.
TEST(HorizonMethod, LetsALongWallJoinSliceBySlice) {
  SceneBuilder builder;
  const scenes::Triangles wall = scenes::box(glm::vec3(5, 0, -400), glm::vec3(6, 30, -10));
  builder.addInstance(builder.addMesh(makeMesh({{wall.positions, wall.indices, true, false}})),
                      scenes::kIdentity, 0);
  const scenes::Triangles of = house(6.0F);
  const MeshId mesh = builder.addMesh(makeMesh({{of.positions, of.indices, true, false}}));
  for (int i = 0; i < 30; ++i) {
    std::array<double, 12> at = scenes::kIdentity;
    at[3] = 14.0;
    at[11] = -40.0 - 12.0 * i;
    builder.addInstance(mesh, at, static_cast<std::uint32_t>(i) + 1);
  }
  const SnapshotPtr scene = builder.finish();
  const std::size_t sliced =
      answerOf("horizon:slice-columns=8", scene, inTheStreet()).visible.size();
  const std::size_t whole =
      answerOf("horizon:slice-columns=0", scene, inTheStreet()).visible.size();
  EXPECT_LT(sliced + 10, whole);
}

TEST(HorizonMethod, LeavesOutOccludersThatWouldHardlyRaiseIt) {
  const SnapshotPtr scene = town(12);
  const Answer all = answerOf("horizon:least-gain=0", scene, inTheStreet());
  const Answer few = answerOf("horizon:least-gain=0.5", scene, inTheStreet());
  EXPECT_LT(few.stats.occluders_drawn, all.stats.occluders_drawn);
}

TEST(HorizonMethod, SeesBelowWhatHangs) {
  SceneBuilder builder;
  const scenes::Triangles bridge = scenes::box(glm::vec3(-50, 5, -31), glm::vec3(50, 30, -30));
  builder.addInstance(builder.addMesh(makeMesh({{bridge.positions, bridge.indices, true, false}})),
                      scenes::kIdentity, 0);
  const scenes::Triangles of = house(2.0F);
  std::array<double, 12> behind = scenes::kIdentity;
  behind[11] = -60.0;
  builder.addInstance(builder.addMesh(makeMesh({{of.positions, of.indices, true, false}})), behind,
                      1);
  EXPECT_EQ(answerOf("horizon", builder.finish(), inTheStreet()).visible,
            (std::vector<ObjectId>{0, 1}));
}

TEST(HorizonMethod, HidesBehindAWallThatTheNearPlaneCuts) {
  SceneBuilder builder;
  const scenes::Triangles wall = scenes::box(glm::vec3(-300, -10, -3), glm::vec3(300, 30, -2));
  std::array<double, 12> turned{0.8, 0, 0.6, 0, 0, 1, 0, 0, -0.6, 0, 0.8, 0};
  builder.addInstance(builder.addMesh(makeMesh({{wall.positions, wall.indices, true, false}})),
                      turned, 0);
  const scenes::Triangles of = house(2.0F);
  std::array<double, 12> behind = scenes::kIdentity;
  behind[3] = -40.0;
  behind[11] = -100.0;
  builder.addInstance(builder.addMesh(makeMesh({{of.positions, of.indices, true, false}})), behind,
                      1);
  EXPECT_EQ(answerOf("horizon", builder.finish(), inTheStreet()).visible,
            (std::vector<ObjectId>{0}));
}

TEST(HorizonMethod, FollowsEditsOfWhatHid) {
  const SnapshotPtr scene = town(6);
  const auto culler = horizonMethod().prepare(scene);
  ASSERT_TRUE(culler.ok());
  ViewState view;
  const Answer before = culler.value()->cull(inTheStreet(), {}, view);
  std::vector<Edit> edits;
  std::vector<ObjectId> changed;
  for (ObjectId id = 0; id < 25; ++id) {  // the first row goes
    edits.push_back(HideObject{id});
    changed.push_back(id);
  }
  const auto next = applyEdits(scene, edits);
  ASSERT_TRUE(next.ok());
  const auto edited = culler.value()->edited(next.value().snapshot, changed);
  ASSERT_TRUE(edited.ok());
  view.sceneEdited();
  const Answer after = edited.value()->cull(inTheStreet(), {}, view);
  EXPECT_EQ(after.visible, answerOf("horizon", next.value().snapshot, inTheStreet()).visible);
  EXPECT_GT(after.visible.size(), 1U);
  EXPECT_GT(after.visible.front(), 24U);
}

TEST(HorizonMethod, AnswersTheFrustumForAMotionBoundAndSaysSo) {
  const SnapshotPtr scene = town(6);
  Camera camera = inTheStreet();
  camera.motion = {.radius_m = 0.5, .angle_rad = 0.1};
  const Answer answer = answerOf("horizon", scene, camera);
  EXPECT_EQ(answer.visible, answerOf("frustum", scene, camera).visible);
  EXPECT_NE(answer.note.find("motion bound"), std::string::npos);
}

TEST(HorizonMethod, StopsWhenItsWorkIsUsedUp) {
  const SnapshotPtr scene = town(40);
  const Answer whole = answerOf("horizon", scene, inTheStreet());
  Demand demand;
  demand.work = whole.stats.work / 3;
  const Answer cut = answerOf("horizon", scene, inTheStreet(), demand);
  EXPECT_TRUE(cut.out_of_budget);
  EXPECT_GT(cut.visible.size(), whole.visible.size());
  EXPECT_TRUE(std::includes(cut.visible.begin(), cut.visible.end(), whole.visible.begin(),
                            whole.visible.end()));
}

TEST(HorizonMethod, RefusesScenesThatAreNot2Point5D) {
  SceneProfile profile;
  EXPECT_TRUE(horizonMethod().accepts(profile).ok());
  profile.overhang = 0.4;
  const auto refused = horizonMethod().accepts(profile);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_NE(refused.error().message.find("2.5D"), std::string::npos);
}

}  // namespace
}  // namespace culld
