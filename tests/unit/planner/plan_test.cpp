// The plan's decisions on generated scenes, with the methods of the product.
#include "culling/planner/plan.h"

#include <gtest/gtest.h>

#include <cmath>

#include "culling/methods/frustum.h"
#include "culling/methods/raster.h"
#include "culling/planner/auto_method.h"
#include "culling/planner/sample_views.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/city.h"
#include "tests/scenes/landscapes.h"

namespace culld {
namespace {

std::span<const Method* const> stages() {
  static const Method* const methods[] = {&frustumMethod(), &rasterMethod()};
  return methods;
}

PreparedPlan planFor(const scenes::Model& model) {
  auto plan = makePlan(scenes::toSnapshot(model), stages(), steadyClock());
  EXPECT_TRUE(plan.ok());
  return std::move(plan).value();
}

struct Decision {
  const char* scene;
  scenes::Model model;
  bool occlusion;
};

TEST(Plan, UsesOcclusionWhereTheSceneHidesMuchAndNowhereElse) {
  std::vector<Decision> table;
  table.push_back({"arena", scenes::arena({}).model, false});
  table.push_back({"large arena", scenes::arena({.objects = 8'000}).model, false});
  table.push_back({"sparse terrain", scenes::sparseTerrain({}).model, false});
  table.push_back({"city", scenes::generateCity({.objects = 5'000}).model, true});
  table.push_back({"closed rooms", scenes::closedRooms({}).model, true});
  for (const Decision& decision : table) {
    const PreparedPlan prepared = planFor(decision.model);
    ASSERT_EQ(prepared.plan->stages.size(), 1U);
    const PlannedStage& stage = prepared.plan->stages[0];
    EXPECT_EQ(stage.built, decision.occlusion) << decision.scene << ": " << prepared.plan->why;
    EXPECT_EQ(prepared.stages[0] != nullptr, decision.occlusion) << decision.scene;
    EXPECT_GE(stage.views.size(), 4U) << decision.scene;
  }
}

TEST(Plan, KeepsOnlyTheFrustumsBoxesForAnOpenScene) {
  const SnapshotPtr scene = scenes::toSnapshot(scenes::arena({}).model);
  const auto automatic = AutoMethod(stages()).prepare(scene, steadyClock());
  const auto frustum = frustumMethod().prepare(scene, steadyClock());
  ASSERT_TRUE(automatic.ok() && frustum.ok());
  EXPECT_EQ(automatic.value()->preparedBytes(), frustum.value()->preparedBytes());
}

TEST(Plan, StopsLookingOnceItHasCountedEnoughWork) {
  const PreparedPlan large = planFor(scenes::generateCity({.objects = 20'000}).model);
  const PreparedPlan small = planFor(scenes::closedRooms({.objects = 400}).model);
  EXPECT_LT(large.plan->stages[0].views.size(), 32U);
  EXPECT_EQ(small.plan->stages[0].views.size(), 32U);
  std::chrono::nanoseconds last = large.plan->stages[0].views.back().work;
  EXPECT_LT(large.plan->planning_work - 2 * last, std::chrono::milliseconds(100));
}

TEST(Plan, BoundsTheWorkOfEachViewWhereThingsStandInOneHeap) {
  RawSurface square;
  square.double_sided = true;
  square.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  square.indices = {0, 1, 2, 0, 2, 3};
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(makeMesh({square}));
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    const double c = std::cos(i), s = std::sin(i);
    builder.addInstance(mesh, {c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 0}, i);
  }
  const auto prepared = makePlan(builder.finish(), stages(), steadyClock());
  ASSERT_TRUE(prepared.ok());
  for (const PlannedView& view : prepared.value().plan->stages[0].views) {
    EXPECT_LT(view.work, std::chrono::milliseconds(120));
  }
}

TEST(Plan, IsTheSameEveryTime) {
  const scenes::Model model = scenes::closedRooms({}).model;
  const PreparedPlan first = planFor(model), second = planFor(model);
  ASSERT_EQ(first.plan->stages[0].views.size(), second.plan->stages[0].views.size());
  EXPECT_EQ(first.plan->why, second.plan->why);
  EXPECT_EQ(first.plan->planning_work, second.plan->planning_work);
}

TEST(Plan, CopesWithASceneOfNothing) {
  const auto plan = makePlan(std::make_shared<const SceneSnapshot>(), stages(), steadyClock());
  ASSERT_TRUE(plan.ok());
  EXPECT_TRUE(plan.value().plan->stages.empty());
}

TEST(SampleViews, AreValidAndTheSameEveryTime) {
  const SnapshotPtr scene = scenes::toSnapshot(scenes::closedRooms({}).model);
  const auto first = sampleViews(*scene, 16), second = sampleViews(*scene, 16);
  ASSERT_EQ(first.size(), 16U);
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].camera.origin_world, second[i].camera.origin_world);
    EXPECT_EQ(first[i].camera.w_row, second[i].camera.w_row);
  }
  EXPECT_TRUE(sampleViews(SceneSnapshot(), 16).empty());
}

}  // namespace
}  // namespace culld
