#include "culling/planner/depth_complexity.h"

#include <gtest/gtest.h>

#include <numeric>

#include "culling/scene/edit.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/city.h"
#include "tests/scenes/landscapes.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

/// `count` squares of 2 m, one behind the other, 1 m apart from z = -10 on.
SnapshotPtr squares(std::uint32_t count) {
  scenes::Triangles square;
  square.positions = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  square.indices = {0, 1, 2, 0, 2, 3};
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(makeMesh({{square.positions, square.indices, true, false}}));
  for (std::uint32_t i = 0; i < count; ++i) {
    std::array<double, 12> at = scenes::kIdentity;
    at[11] = -10.0 - i;
    builder.addInstance(mesh, at, i);
  }
  return builder.finish();
}

/// Sees a square of 4 m at the distance of 10 m.
Camera ahead(std::optional<double> far = {}, double near = 0.1) {
  LookAt look;
  look.aspect = 1.0;
  look.yfov_rad = 2.0 * std::atan(0.2);
  look.zfar_m = far;
  look.znear_m = near;
  return cameraFromLookAt(look, {64, 64}).value();
}

std::uint32_t atPixel(const DepthComplexity& depth, std::uint32_t x, std::uint32_t y) {
  return depth.surfaces[y * depth.width_px + x];
}

TEST(DepthComplexity, CountsSurfacesBehindEachOther) {
  const DepthComplexity depth = depthComplexity(*squares(3), ahead(), 64, 64);
  EXPECT_EQ(atPixel(depth, 32, 32), 3U);
  EXPECT_EQ(atPixel(depth, 16, 32), 1U) << "the nearest is the largest";
  EXPECT_EQ(atPixel(depth, 15, 32), 0U);
  EXPECT_EQ(depth.most(), 3U);
}

TEST(DepthComplexity, CountsEdgesBetweenTrianglesOnce) {
  const DepthComplexity depth = depthComplexity(*squares(1), ahead(), 64, 64);
  EXPECT_EQ(depth.most(), 1U);
  EXPECT_EQ(std::accumulate(depth.surfaces.begin(), depth.surfaces.end(), 0U), 32U * 32U);
  EXPECT_DOUBLE_EQ(depth.mean(), 0.25);
}

TEST(DepthComplexity, CountsBothSidesOfABox) {
  const scenes::Triangles box = scenes::box(glm::vec3(-1, -1, -12), glm::vec3(1, 1, -10));
  SceneBuilder builder;
  builder.addInstance(builder.addMesh(makeMesh({{box.positions, box.indices, false, false}})),
                      scenes::kIdentity, 0);
  const DepthComplexity depth = depthComplexity(*builder.finish(), ahead(), 64, 64);
  EXPECT_EQ(atPixel(depth, 32, 32), 2U);
  EXPECT_EQ(depth.most(), 2U);
}

TEST(DepthComplexity, EndsAtTheClipPlanes) {
  EXPECT_EQ(depthComplexity(*squares(9), ahead(12.5), 64, 64).most(), 3U);
  EXPECT_EQ(depthComplexity(*squares(9), ahead({}, 12.5), 64, 64).most(), 6U);
}

TEST(DepthComplexity, CutsWhatReachesBehindTheEye) {
  const scenes::Triangles wall = scenes::box(glm::vec3(-2, -50, -90), glm::vec3(-1, 50, 90));
  SceneBuilder builder;
  builder.addInstance(builder.addMesh(makeMesh({{wall.positions, wall.indices, true, false}})),
                      scenes::kIdentity, 0);
  const DepthComplexity depth = depthComplexity(*builder.finish(), ahead(), 64, 64);
  EXPECT_EQ(atPixel(depth, 2, 32), 2U);
  EXPECT_EQ(atPixel(depth, 40, 32), 0U);
}

TEST(DepthComplexity, LeavesOutHiddenObjects) {
  const auto edited = applyEdits(squares(3), std::vector<Edit>{HideObject{1}});
  ASSERT_TRUE(edited.ok());
  EXPECT_EQ(depthComplexity(*edited.value().snapshot, ahead(), 64, 64).most(), 2U);
}

TEST(DepthComplexity, SaysHowManyPixelsHaveHowMany) {
  const DepthComplexity depth = depthComplexity(*squares(1), ahead(), 64, 64);
  EXPECT_EQ(depth.histogram(), (std::vector<std::uint64_t>{64 * 64 - 32 * 32, 32 * 32}));
  EXPECT_EQ(depth.percentile(0.7), 0U);
  EXPECT_EQ(depth.percentile(0.8), 1U);
  EXPECT_EQ(depth.percentile(1.0), 1U);
}

TEST(DepthComplexity, IsNoneWithoutObjects) {
  const DepthComplexity depth = depthComplexity(*SceneBuilder().finish(), ahead(), 8, 8);
  EXPECT_EQ(depth.most(), 0U);
  EXPECT_EQ(depth.percentile(0.95), 0U);
  EXPECT_EQ(DepthComplexity().mean(), 0.0);
}

TEST(DepthComplexity, IsHigherInRoomsThanInOpenCountry) {
  const auto of = [](const scenes::Landscape& land) {
    const auto scene = scenes::toSnapshot(land.model);
    const auto camera = scenes::toCamera(land.cameras.front()).value();
    return depthComplexity(*scene, camera, 64, 36).mean();
  };
  EXPECT_GT(of(scenes::closedRooms({})), 2.0 * of(scenes::sparseTerrain({})));
}

}  // namespace
}  // namespace culld
