#include "culling/methods/polygon_tiling.h"

#include <gtest/gtest.h>

#include "culling/methods/frustum.h"
#include "tests/unit/spatial/box_scene.h"

namespace culld::testing {
namespace {

std::unique_ptr<Culler> prepared(const SnapshotPtr& scene, const std::string& settings = "") {
  static ConfiguredMethods methods(allMethods());
  auto method = methods.find("polygon-tiling" + settings);
  EXPECT_TRUE(method.ok());
  auto culler = method.value()->prepare(scene);
  EXPECT_TRUE(culler.ok());
  return std::move(culler).value();
}

Camera lookingFrom(const glm::dvec3& eye, const glm::dvec3& target, MotionBound motion = {}) {
  LookAt look;
  look.eye = eye;
  look.target = target;
  return cameraFromLookAt(look, {640, 360}, motion).value();
}

/// Down -z, or nearly: turned about y by `turn_rad`, then about the line of sight by `roll_rad`.
Camera orthographic(double turn_rad, double roll_rad = 0.0) {
  const double c = std::cos(turn_rad), s = std::sin(turn_rad);
  const double u = std::cos(roll_rad), v = std::sin(roll_rad);
  glm::dmat4 view(1.0), projection(1.0);
  view[0] = {u * c, v * c, s, 0.0};
  view[1] = {-v, u, 0.0, 0.0};
  view[2] = {-u * s, -v * s, c, 0.0};
  view[3] = {0.0, 0.0, -40.0, 1.0};
  projection[0][0] = projection[1][1] = 1.0 / 30.0;
  projection[2][2] = -2.0 / 300.0;
  projection[3][2] = -1.0;
  return cameraFromMatrices(view, projection, {400, 400}).value();
}

/// Walls behind walls, and small things between them.
SnapshotPtr wallsAndThings() {
  std::vector<std::array<double, 12>> boxes;
  for (int wall = 0; wall < 8; ++wall) {
    boxes.push_back(placed({-50.0, -30.0, -20.0 * wall}, {100.0, 60.0, 1.0}));
    for (int i = 0; i < 60; ++i)
      boxes.push_back(placed({1.2 * i - 40.0, 1.0, -20.0 * wall - 3.0 - i % 13}, glm::dvec3(0.8)));
  }
  return boxScene(boxes);
}

Answer answered(const SnapshotPtr& scene, const Camera& camera, const std::string& settings = "") {
  ViewState view;
  return prepared(scene, settings)->cull(camera, {}, view);
}

TEST(PolygonTiling, HidesBehindWallsWithoutDepths) {
  const SnapshotPtr scene = wallsAndThings();
  const Answer answer = answered(scene, lookingFrom({0.3, 2.1, 20.2}, {0.0, 2.0, -100.0}));
  EXPECT_LT(answer.visible.size(), 60U);  // of 488
  EXPECT_GT(answer.stats.occluders_drawn, 0U);
  const Answer parallel = answered(scene, orthographic(0.1));
  EXPECT_TRUE(parallel.note.empty()) << parallel.note;
  EXPECT_LT(parallel.visible.size(), 240U);
  EXPECT_LT(answered(scene, orthographic(0.0)).visible.size(), 240U);
}

TEST(PolygonTiling, BspTreesOrderWhatCubesDoNot) {
  const SnapshotPtr scene = wallsAndThings();
  const Camera camera = lookingFrom({0.3, 2.1, 20.2}, {0.0, 2.0, -100.0});
  const std::size_t with = answered(scene, camera).visible.size();
  EXPECT_LT(with, answered(scene, camera, ":bsp=off").visible.size());
}

TEST(PolygonTiling, LevelsSaveMaskComparisons) {
  const SnapshotPtr scene = wallsAndThings();
  const Camera camera = lookingFrom({0.3, 2.1, 20.2}, {0.0, 2.0, -100.0});
  const Answer all = answered(scene, camera), none = answered(scene, camera, ":levels=0");
  EXPECT_EQ(all.visible, none.visible);
  EXPECT_LT(2 * all.stats.depth_comparisons, none.stats.depth_comparisons);
}

TEST(PolygonTiling, WhatIsAtTheSameDepthHidesNothing) {
  // A panel on the side of a box, and a box whose side lies in the panel's plane.
  const SnapshotPtr scene =
      boxScene({placed({-4, -4, -20}, {8, 8, 0}), placed({-2, -2, -24}, {4, 4, 4})});
  for (const double z : {10.0, 0.0, -19.0}) {
    const Answer answer = answered(scene, lookingFrom({0.1, 0.2, z}, {0, 0, -22}));
    EXPECT_EQ(answer.visible, (std::vector<ObjectId>{0, 1})) << z;
  }
}

TEST(PolygonTiling, AnswersTheFrustumsWhereThereIsNoStrictOrder) {
  const SnapshotPtr scene = wallsAndThings();
  const auto frustum = frustumMethod().prepare(scene);
  ASSERT_TRUE(frustum.ok());
  for (const Camera& camera :
       {lookingFrom({0, 2, 20}, {0, 2, -100}, {.radius_m = 0.01}), orthographic(0.3, 0.2)}) {
    const Answer answer = answered(scene, camera);
    ViewState view;
    EXPECT_FALSE(answer.note.empty());
    EXPECT_EQ(answer.visible, frustum.value()->cull(camera, {}, view).visible);
  }
}

}  // namespace
}  // namespace culld::testing
