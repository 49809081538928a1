#include "culling/planner/scene_shape.h"

#include <gtest/gtest.h>

#include "tests/scenes/city.h"
#include "tests/scenes/landscapes.h"

namespace culld {
namespace {

SceneShape shapeOfModel(const scenes::Model& model) { return shapeOf(*scenes::toSnapshot(model)); }

TEST(SceneShape, IsZeroForAnEmptyScene) {
  const SceneShape shape = shapeOf(SceneSnapshot());
  EXPECT_EQ(shape.depth_complexity, 0.0);
  EXPECT_EQ(shape.median_m, 0.0);
}

TEST(SceneShape, TellsClosedRoomsFromOpenCountry) {
  const SceneShape rooms = shapeOfModel(scenes::closedRooms({}).model);
  const SceneShape terrain = shapeOfModel(scenes::sparseTerrain({}).model);
  EXPECT_GT(rooms.closedness, 0.7);
  EXPECT_GT(rooms.closedness, terrain.closedness + 0.1);
  EXPECT_GT(rooms.depth_complexity, 2.0 * terrain.depth_complexity);
  EXPECT_GT(rooms.occluder_potential, terrain.occluder_potential);
}

TEST(SceneShape, SeesThatStoneFieldsStandOnTheGroundAndStoreysDoNot) {
  EXPECT_GT(shapeOfModel(scenes::sparseTerrain({}).model).upright, 0.9);
  EXPECT_LT(shapeOfModel(scenes::closedRooms({}).model).upright, 0.9);
}

TEST(SceneShape, OrdersSizes) {
  const SceneShape shape = shapeOfModel(scenes::generateCity({.objects = 3000}).model);
  EXPECT_GT(shape.small_m, 0.0);
  EXPECT_LT(shape.small_m, shape.median_m);
  EXPECT_LT(shape.median_m, shape.large_m);
}

TEST(SceneShape, IsTheSameEveryTime) {
  const auto scene = scenes::toSnapshot(scenes::closedRooms({}).model);
  EXPECT_EQ(shapeOf(*scene).depth_complexity, shapeOf(*scene).depth_complexity);
}

}  // namespace
}  // namespace culld
