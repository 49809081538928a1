#include "culling/methods/layers.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "culling/scene/scene_builder.h"
#include "tests/scenes/city.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

std::unique_ptr<Culler> prepared(const std::string& settings, const SnapshotPtr& scene) {
  const Method* const table[] = {&layersMethod()};
  ConfiguredMethods methods(table);
  const auto method = methods.find("layers" + settings);
  EXPECT_TRUE(method.ok());
  return method.value()->prepare(scene, steadyClock()).value();
}

Demand lossy(float accepted_px) {
  Demand demand;
  demand.guarantee = Guarantee::kApproximate;
  demand.accepted_missed_px = accepted_px;
  return demand;
}

struct Town {
  scenes::City city = scenes::generateCity({.seed = 3, .objects = 4'000, .frames = 24});
  SnapshotPtr scene = scenes::toSnapshot(city.model);
};

const Town& town() {
  static const Town once;
  return once;
}

std::size_t answered(const std::string& settings, const Demand& demand = {}) {
  const auto culler = prepared(settings, town().scene);
  std::size_t sum = 0;
  ViewState view;
  for (const scenes::CameraSpec& spec : town().city.cameras) {
    sum += culler->cull(scenes::toCamera(spec).value(), demand, view).visible.size();
  }
  return sum;
}

TEST(Layers, LeavesOutMostOfATown) { EXPECT_LT(2 * answered(""), answered(":polygons=0")); }

TEST(Layers, AnswersFewerTheMoreIsAccepted) {
  const std::size_t all = answered(":polygons=0");  // the frustum's answer
  const std::size_t some = answered("", lossy(5'000.0F));
  const std::size_t few = answered("", lossy(100'000.0F));
  EXPECT_LT(few, some);
  EXPECT_LT(some, all);
}

TEST(Layers, EstimatesNoMoreThanWasAccepted) {
  const auto culler = prepared("", town().scene);
  ViewState view;
  for (const scenes::CameraSpec& spec : town().city.cameras) {
    const Answer answer = culler->cull(scenes::toCamera(spec).value(), lossy(20'000.0F), view);
    EXPECT_EQ(answer.guarantee, Guarantee::kApproximate);
    EXPECT_FALSE(answer.proven);
    EXPECT_LE(answer.missed_px, 20'000.0F);
  }
}

/// Before the eye, half of the view is a wall of boxes with many things close behind it; the other
/// half is open, and things stand there farther away.
struct HalfOpen {
  HalfOpen() {
    SceneBuilder builder;
    const scenes::Triangles t = scenes::box(glm::vec3(0), glm::vec3(1));
    const MeshId cube = builder.addMesh(makeMesh({{t.positions, t.indices, true, false}}));
    std::uint32_t node = 0;
    const auto add = [&](const glm::dvec3& at, double size) {
      builder.addInstance(cube, {size, 0, 0, at.x, 0, size, 0, at.y, 0, 0, size, at.z}, node++);
    };
    for (int i = 0; i < 200; ++i) add({-10 + i % 10, -10 + i / 10, -10}, 1.0);  // the wall
    for (int i = 0; i < 800; ++i) {
      add({-9.5 + i % 10, -8 + i / 10 % 16, -13.0 - i / 160}, 0.5);  // behind it
    }
    first_seen = node;
    for (int i = 0; i < 40; ++i) add({2 + i % 5, -4 + i / 5, -26}, 0.9);  // in the open
    scene = builder.finish();
  }
  ObjectId first_seen = 0;
  SnapshotPtr scene;
};

std::size_t seenWithinBudget(const HalfOpen& world, const std::string& settings) {
  const auto culler = prepared(":accept-px=1:triangles=5000:cells=1" + settings, world.scene);
  ViewState view;
  const Answer answer = culler->cull(cameraFromLookAt({}, {}).value(), lossy(0.0F), view);
  EXPECT_GT(answer.missed_px, 1.0F);  // the budget ended it
  return static_cast<std::size_t>(
      std::count_if(answer.visible.begin(), answer.visible.end(),
                    [&](ObjectId id) { return id >= world.first_seen; }));
}

TEST(Layers, SpendsItsBudgetWhereSightIsClear) {
  const HalfOpen world;
  EXPECT_GT(seenWithinBudget(world, ":solidity=0.7"), seenWithinBudget(world, ":solidity=0"));
}

TEST(Layers, FitsItsCellsToTheNumberOfObjects) {
  EXPECT_GT(prepared(":cells=8", town().scene)->preparedBytes(),
            prepared(":cells=0.1", town().scene)->preparedBytes());
}

TEST(Layers, KeepsWhatADemandAcceptsWhateverTheBudget) {
  const auto culler = prepared(":accept-px=1:triangles=100", town().scene);
  ViewState view;
  const Camera camera = scenes::toCamera(town().city.cameras[0]).value();
  EXPECT_LE(culler->cull(camera, lossy(1'000.0F), view).missed_px, 1'000.0F);
  EXPECT_EQ(culler->cull(camera, {}, view).guarantee, Guarantee::kConservative);
}

TEST(Layers, LosesNothingForAnEyeThatMoves) {
  const auto culler = prepared("", town().scene);
  Camera camera = scenes::toCamera(town().city.cameras[0]).value();
  camera.motion.radius_m = 0.1;
  ViewState view;
  const Answer answer = culler->cull(camera, lossy(1e6F), view);
  EXPECT_EQ(answer.guarantee, Guarantee::kConservative);
  EXPECT_EQ(answer.missed_px, 0.0F);
}

}  // namespace
}  // namespace culld
