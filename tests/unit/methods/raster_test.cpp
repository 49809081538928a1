#include "culling/methods/raster.h"

#include <gtest/gtest.h>

#include "culling/methods/frustum.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"
#include "tests/unit/spatial/box_scene.h"

namespace culld::testing {
namespace {

Camera lookingFrom(double x) {
  LookAt look;
  look.eye = {x, 10.0, 120.0};
  look.target = {0.5 * x, 0.0, 0.0};
  return cameraFromLookAt(look, {}).value();
}

TEST(Raster, CountsAsManyObjectsInTheFrustumAsTheFrustumFinds) {
  for (const std::size_t count : {100U, 5000U}) {
    const SnapshotPtr scene = boxScene(randomBoxes(count, {0, 0, 0}, 60.0, 3));
    const auto raster = rasterMethod().prepare(scene);
    const auto frustum = frustumMethod().prepare(scene);
    ASSERT_TRUE(raster.ok() && frustum.ok());
    std::size_t hidden = 0;
    for (int n = 0; n < 20; ++n) {
      ViewState view;
      const Answer with = raster.value()->cull(lookingFrom(6.0 * n - 60.0), {}, view);
      const Answer without = frustum.value()->cull(lookingFrom(6.0 * n - 60.0), {}, view);
      EXPECT_EQ(with.stats.in_frustum, without.stats.in_frustum);
      EXPECT_LE(with.visible.size(), without.visible.size());
      hidden += without.visible.size() - with.visible.size();
    }
    EXPECT_GT(hidden, 0U);
  }
}

TEST(Raster, SharesTheBoxesOfAnotherMethodsCuller) {
  const SnapshotPtr scene = boxScene(randomBoxes(5000, {0, 0, 0}, 60.0, 3));
  const auto frustum = frustumMethod().prepare(scene);
  ASSERT_TRUE(frustum.ok());
  const auto beside = rasterMethod().prepareBeside(*frustum.value(), scene, steadyClock());
  const auto alone = rasterMethod().prepare(scene);
  ASSERT_TRUE(beside.ok() && alone.ok());
  ViewState one, other;
  EXPECT_EQ(beside.value()->cull(lookingFrom(0), {}, one).visible,
            alone.value()->cull(lookingFrom(0), {}, other).visible);
}

TEST(Raster, PricesItsWork) {
  const SnapshotPtr scene = boxScene(randomBoxes(5000, {0, 0, 0}, 60.0, 3));
  const auto raster = rasterMethod().prepare(scene);
  const auto frustum = frustumMethod().prepare(scene);
  ViewState one, other;
  const auto with = raster.value()->cull(lookingFrom(0), {}, one).stats;
  const auto without = frustum.value()->cull(lookingFrom(0), {}, other).stats;
  EXPECT_GT(without.work.count(), 0);
  EXPECT_GT(with.work, without.work);
}

/// One object whose mesh is `side` x `side` boxes side by side.
SnapshotPtr wallOfBoxes(int side) {
  scenes::Triangles wall;
  const scenes::Triangles box = scenes::box(glm::vec3(0), glm::vec3(0.5F));
  for (int i = 0; i < side * side; ++i) {
    scenes::append(wall, box, scenes::movedBy({i % side - side / 2, i / side - side / 2, 0}));
  }
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(makeMesh({{wall.positions, wall.indices, true, false}}));
  builder.addInstance(mesh, scenes::kIdentity, 0);
  return builder.finish();
}

TEST(Raster, StopsWithinAMeshOfManyPieces) {
  const SnapshotPtr scene = wallOfBoxes(64);
  const auto raster = rasterMethod().prepare(scene);
  ASSERT_TRUE(raster.ok());
  LookAt look;
  look.eye = {0, 0, 60};
  const Camera camera = cameraFromLookAt(look, {}).value();
  ViewState one, other;
  const Answer whole = raster.value()->cull(camera, {}, one);
  EXPECT_FALSE(whole.out_of_budget);
  EXPECT_GE(whole.stats.triangles_drawn, 64U * 64U);
  Demand short_of_work;
  short_of_work.work = whole.stats.work / 8;
  const Answer cut = raster.value()->cull(camera, short_of_work, other);
  EXPECT_TRUE(cut.out_of_budget);
  EXPECT_EQ(cut.visible, whole.visible);
  EXPECT_GT(cut.stats.triangles_drawn, 0U);
  EXPECT_LT(cut.stats.work, 2 * short_of_work.work);
}

}  // namespace
}  // namespace culld::testing
