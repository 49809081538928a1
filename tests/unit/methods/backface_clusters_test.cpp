#include "culling/methods/backface_clusters.h"

#include <gtest/gtest.h>

#include "culling/scene/edit.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/city.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

std::unique_ptr<Culler> prepared(const std::string& settings, const SnapshotPtr& scene) {
  const Method* const table[] = {&backfaceClustersMethod()};
  ConfiguredMethods methods(table);
  const auto method = methods.find("backface-clusters" + settings);
  EXPECT_TRUE(method.ok());
  return method.value()->prepare(scene, steadyClock()).value();
}

/// Rows of balls, and between them walls that show their backs to an eye that looks down -z.
SnapshotPtr gallery() {
  scenes::Random random(1);
  SceneBuilder builder;
  const auto mesh = [&](const scenes::Triangles& t) {
    return builder.addMesh(makeMesh({{t.positions, t.indices, true, false}}));
  };
  const MeshId ball = mesh(scenes::ball(16, 0.2, random));
  const MeshId wall = mesh(scenes::quad({-1, -1, 0}, {0, 2, 0}, {2, 0, 0}));  // front to -z
  std::uint32_t node = 0;
  for (int row = 0; row < 6; ++row) {
    for (int i = -10; i <= 10; ++i) {
      const double x = 2.5 * i, z = -8.0 - 5.0 * row;
      builder.addInstance(ball, {1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, z}, node++);
      builder.addInstance(wall, {1, 0, 0, x, 0, 1, 0, 3, 0, 0, 1, z}, node++);
    }
  }
  return builder.finish();
}

Answer look(const SnapshotPtr& scene, const std::string& settings, const Camera& camera) {
  ViewState view;
  return prepared(settings, scene)->cull(camera, {}, view);
}

Camera ahead() { return cameraFromLookAt({}, {}).value(); }

TEST(BackfaceClusters, LeavesOutObjectsThatTurnAway) {
  const SnapshotPtr scene = gallery();
  const Answer all = look(scene, ":objects=off:occluders=off", ahead());
  const Answer fewer = look(scene, ":occluders=off", ahead());
  EXPECT_EQ(all.stats.occluded, 0U);
  EXPECT_GT(fewer.stats.occluded, 20U);
  EXPECT_EQ(fewer.visible.size() + fewer.stats.occluded, all.visible.size());
  EXPECT_EQ(fewer.stats.in_frustum, all.stats.in_frustum);
}

TEST(BackfaceClusters, LeavesOutClustersOfOccludersAndAnswersTheSame) {
  const SnapshotPtr scene = gallery();
  const std::string ample = ":triangles=10000000";
  const Answer whole = look(scene, ample + ":clusters=off", ahead());
  const Answer parts = look(scene, ample, ahead());
  EXPECT_EQ(parts.visible, whole.visible);
  EXPECT_EQ(parts.stats.triangles_drawn, whole.stats.triangles_drawn);
  EXPECT_LT(parts.stats.work, whole.stats.work);  // as fewer triangles were asked one by one
  EXPECT_GT(parts.stats.occluders_drawn, 10U);
}

TEST(BackfaceClusters, ChargesOnlyTrianglesThatAreLookedAt) {
  scenes::Random random(1);
  const scenes::Triangles ball = scenes::ball(16, 0.0, random);
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(makeMesh({{ball.positions, ball.indices, true, false}}));
  for (std::uint32_t i = 0; i < 4; ++i) {
    builder.addInstance(mesh, {1, 0, 0, 3.0 * i - 4.5, 0, 1, 0, 0, 0, 0, 1, -8}, i);
  }
  const SnapshotPtr scene = builder.finish();
  const std::string budget = ":triangles=" + std::to_string(ball.indices.size() / 3 * 2);
  EXPECT_EQ(look(scene, budget, ahead()).stats.occluders_drawn, 3U);
  EXPECT_EQ(look(scene, budget + ":clusters=off", ahead()).stats.occluders_drawn, 2U);
}

TEST(BackfaceClusters, HidesWhatOccludersCover) {
  const SnapshotPtr scene = gallery();
  const Answer none = look(scene, ":occluders=off", ahead()), some = look(scene, "", ahead());
  EXPECT_GT(some.stats.occluders_drawn, 10U);
  EXPECT_LT(some.visible.size(), none.visible.size());
}

TEST(BackfaceClusters, TheHierarchyAsksFewerClusters) {
  const SnapshotPtr scene = gallery();
  const Answer from_top = look(scene, "", ahead()), leaves = look(scene, ":hierarchy=off", ahead());
  EXPECT_EQ(from_top.visible, leaves.visible);
  EXPECT_LT(from_top.stats.plane_tests, leaves.stats.plane_tests);
}

TEST(BackfaceClusters, KeepsWhatAnEyeWithinTheMotionBoundMaySee) {
  const SnapshotPtr scene = gallery();
  Camera camera = ahead();
  camera.motion.radius_m = 100.0;
  EXPECT_EQ(look(scene, ":occluders=off", camera).stats.occluded, 0U);
}

TEST(BackfaceClusters, AWallThatIsTurnedRoundIsSeen) {
  const SnapshotPtr scene = gallery();
  const auto culler = prepared(":occluders=off", scene);
  ViewState view;
  const std::size_t before = culler->cull(ahead(), {}, view).visible.size();
  const Edit turned = MoveObject{21, {-1, 0, 0, 0, 0, 1, 0, 3, 0, 0, -1, -8}};  // in the middle
  const EditedScene edited = applyEdits(scene, {&turned, 1}).value();
  const auto next = culler->edited(edited.snapshot, edited.changed).value();
  EXPECT_EQ(next->cull(ahead(), {}, view).visible.size(), before + 1);
}

TEST(BackfaceClusters, StopsBetweenObjectsOfOneNode) {
  // Bumpy ground seen from below: each piece takes many clusters to tell that it turns away.
  scenes::Random random(3);
  const scenes::Triangles ground = scenes::bumpySheet(60, 0.02, random);
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(makeMesh({{ground.positions, ground.indices, true, false}}));
  for (std::uint32_t i = 0; i < 200; ++i) {
    builder.addInstance(mesh, {1, 0, 0, 0.1 * (i % 20), 0, 1, 0, 0.1 * (i / 20), 0, 0, 1, -9}, i);
  }
  const auto culler = prepared(":occluders=off:hierarchy=off", builder.finish());
  LookAt from_below;
  from_below.eye = {1, -10, -9};
  from_below.target = {1, 0, -8};
  const Camera camera = cameraFromLookAt(from_below, {}).value();
  ViewState view;
  const Answer whole = culler->cull(camera, {}, view);
  EXPECT_FALSE(whole.out_of_budget);
  EXPECT_GT(whole.stats.work, std::chrono::milliseconds(1));
  for (int part = 2; part < 12; ++part) {
    Demand demand;
    demand.work = whole.stats.work / part;
    const Answer cut = culler->cull(camera, demand, view);
    EXPECT_TRUE(cut.out_of_budget);
    EXPECT_LT(cut.stats.work, demand.work + whole.stats.work / 100);  // two objects of 200
    EXPECT_GT(cut.visible.size(), whole.visible.size());
  }
}

TEST(BackfaceClusters, AnswersTheSameWhateverAViewRemembers) {
  const scenes::City city = scenes::generateCity({.seed = 2, .objects = 2'000, .frames = 12});
  const auto culler = prepared("", scenes::toSnapshot(city.model));
  ViewState kept;
  for (const scenes::CameraSpec& spec : city.cameras) {
    const Camera camera = scenes::toCamera(spec).value();
    ViewState fresh;
    EXPECT_EQ(culler->cull(camera, {}, kept).visible, culler->cull(camera, {}, fresh).visible);
  }
}

}  // namespace
}  // namespace culld
