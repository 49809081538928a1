#include "culling/methods/occlusion_map.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "culling/scene/scene_builder.h"
#include "tests/scenes/city.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

/// A town, and cameras in its streets.
struct Town {
  scenes::City city = scenes::generateCity({.seed = 3, .objects = 4'000, .frames = 24});
  SnapshotPtr scene = scenes::toSnapshot(city.model);
};

const Town& town() {
  static const Town once;
  return once;
}

struct Sums {
  std::size_t answered = 0;
  std::uint64_t drawn = 0, triangles = 0;
  std::chrono::nanoseconds work{0};
  double missed_px = 0.0;
};

/// `settings` as users write them behind the method's name: ":levels=0".
Sums sumsOf(const std::string& settings, const Demand& demand = {}) {
  const Method* const table[] = {&occlusionMapMethod()};
  ConfiguredMethods methods(table);
  const auto method = methods.find("occlusion-map" + settings);
  EXPECT_TRUE(method.ok());
  const auto culler = method.value()->prepare(town().scene, steadyClock());
  EXPECT_TRUE(culler.ok());
  Sums sums;
  ViewState view;
  for (const scenes::CameraSpec& spec : town().city.cameras) {
    const Answer answer = culler.value()->cull(scenes::toCamera(spec).value(), demand, view);
    sums.answered += answer.visible.size();
    sums.drawn += answer.stats.occluders_drawn;
    sums.triangles += answer.stats.triangles_drawn;
    sums.work += answer.stats.work;
    sums.missed_px += static_cast<double>(answer.missed_px);
    EXPECT_EQ(answer.guarantee, demand.accepted_missed_px > 0.0F ? Guarantee::kApproximate
                                                                 : Guarantee::kConservative);
  }
  return sums;
}

const Sums& standard() {
  static const Sums once = sumsOf("");
  return once;
}

TEST(OcclusionMapMethod, LeavesOutMostOfATown) {
  const Sums none = sumsOf(":occluders=0");  // the frustum's answer
  EXPECT_EQ(none.drawn, 0U);
  EXPECT_LT(2 * standard().answered, none.answered);
}

TEST(OcclusionMapMethod, DrawsNoMoreThanItsBudget) {
  const Sums few = sumsOf(":occluders=16");
  EXPECT_LE(few.drawn, 16 * town().city.cameras.size());
  EXPECT_GT(few.answered, standard().answered);
  const Sums simple = sumsOf(":polygons=100");
  EXPECT_LT(simple.triangles, standard().triangles);
  EXPECT_GT(simple.answered, standard().answered);
}

TEST(OcclusionMapMethod, LooksAtMoreTexelsWithoutThePyramid) {
  const Sums flat = sumsOf(":levels=0");
  EXPECT_EQ(flat.answered, standard().answered);
  EXPECT_GT(flat.work, standard().work);
}

TEST(OcclusionMapMethod, KeepsMoreWhereItGivesUpEarly) {
  const Sums hasty = sumsOf(":give-up=0.1");
  EXPECT_GT(hasty.answered, standard().answered);
}

TEST(OcclusionMapMethod, HidesLessByTheDepthOfBoxesThanOfCells) {
  const Sums boxes = sumsOf(":depth-of-cells=off");
  EXPECT_GT(boxes.answered, standard().answered);
  const Sums none = sumsOf(":occluders=0");
  EXPECT_LT(boxes.answered, none.answered);
}

TEST(OcclusionMapMethod, HidesMoreWithFinerRegionsOfDepth) {
  const Sums coarse = sumsOf(":depth-regions=8");
  EXPECT_GT(coarse.answered, standard().answered);
}

TEST(OcclusionMapMethod, DrawsMoreOccludersForNothingWithoutItsDatabase) {
  const Sums every = sumsOf(":least-size=0:most-polygons=0:least-fill=0:drop-redundant=off");
  EXPECT_GT(every.drawn, standard().drawn);
  EXPECT_LT(standard().answered, every.answered + every.answered / 20);
}

TEST(OcclusionMapMethod, LosesNoMorePixelsThanAccepted) {
  Demand demand;
  demand.guarantee = Guarantee::kApproximate;
  demand.accepted_missed_px = 500.0F;
  const Sums lossy = sumsOf("", demand);
  EXPECT_LT(lossy.answered, standard().answered);
  EXPECT_GT(lossy.missed_px, 0.0);
  EXPECT_LE(lossy.missed_px, 500.0 * static_cast<double>(town().city.cameras.size()));
  const Sums opaque = sumsOf(":opacity=1", demand);
  EXPECT_EQ(opaque.answered, standard().answered);
  EXPECT_EQ(opaque.missed_px, 0.0);
}

TEST(OcclusionMapMethod, AcceptsALossBySettingOnlyWhereTheDemandDoes) {
  const Method* const table[] = {&occlusionMapMethod()};
  ConfiguredMethods methods(table);
  EXPECT_EQ(methods.find("occlusion-map:accept-px=300").value()->info().guarantee,
            Guarantee::kApproximate);
  EXPECT_EQ(sumsOf(":accept-px=300").answered, standard().answered);
}

/// A wall with a hole of one cell or so, and behind it a box; and a pane of glass beside the box.
TEST(OcclusionMapMethod, LosesWhatShinesThroughAHoleButNoGlass) {
  SceneBuilder builder;
  const auto add = [&](const scenes::Triangles& t, const glm::dvec3& at, bool blocks) {
    const MeshId mesh = builder.addMesh(makeMesh({{t.positions, t.indices, blocks, false}}));
    builder.addInstance(mesh, {1, 0, 0, at.x, 0, 1, 0, at.y, 0, 0, 1, at.z}, 0);
  };
  const auto hole = scenes::wallWithHole({0, 0}, {0.0005F, 0.0005F});
  scenes::Triangles wall;
  scenes::append(wall, hole, scenes::scaledAndMoved({8, 8, 1}, {0, 0, 0}));
  add(wall, {0, 0, -6}, true);
  add(scenes::box(glm::vec3(-1), glm::vec3(1)), {0, 0, -20}, true);
  add(scenes::box(glm::vec3(-1), glm::vec3(1)), {0, 0, -30}, false);
  const SnapshotPtr scene = builder.finish();
  const auto culler = occlusionMapMethod().prepare(scene);
  ASSERT_TRUE(culler.ok());
  const Camera camera = cameraFromLookAt({}, {}).value();
  ViewState view;
  EXPECT_EQ(culler.value()->cull(camera, {}, view).visible, (std::vector<ObjectId>{0, 1, 2}));
  Demand demand;
  demand.guarantee = Guarantee::kApproximate;
  demand.accepted_missed_px = 64.0F;
  const Answer lossy = culler.value()->cull(camera, demand, view);
  EXPECT_EQ(lossy.visible, (std::vector<ObjectId>{0, 2}));
  EXPECT_GT(lossy.missed_px, 0.0F);
  EXPECT_TRUE(lossy.proven);
  Camera moving = camera;
  moving.motion.radius_m = 0.01;
  const Answer moved = culler.value()->cull(moving, demand, view);
  EXPECT_EQ(moved.visible, (std::vector<ObjectId>{0, 1, 2}));
  EXPECT_EQ(moved.guarantee, Guarantee::kConservative);
}

}  // namespace
}  // namespace culld
