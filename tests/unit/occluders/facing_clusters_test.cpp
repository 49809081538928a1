#include "culling/occluders/facing_clusters.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

constexpr std::uint64_t kAllRegions = 1'000'000;
constexpr std::array<double, 12> kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

Mesh meshOf(const scenes::Triangles& t, bool double_sided = false) {
  return makeMesh({{t.positions, t.indices, true, double_sided}});
}

Mesh ball(std::uint32_t rings = 16) {
  scenes::Random random(1);
  return meshOf(scenes::ball(rings, 0.0, random));
}

/// The square [-1, 1]^2 in xy, front to +z.
Mesh square(bool double_sided = false) {
  return meshOf(scenes::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}), double_sided);
}

VolumeEye eyeAt(const glm::dvec3& place, double radius_m = 0.0) {
  VolumeEye eye;
  eye.origin_world = place;
  eye.radius_m = radius_m;
  return eye;
}

bool away(const Mesh& mesh, const VolumeEye& eye,
          const std::array<double, 12>& placed = kIdentity) {
  std::uint64_t regions = 0;
  const auto mesh_eye = meshEye(placed, eye);
  return mesh_eye && FacingClusters::of(mesh, {}).turnedAway(*mesh_eye, true, kAllRegions, regions);
}

TEST(FacingClusters, ASquareTurnsAwayBehindItsPlaneOnly) {
  EXPECT_TRUE(away(square(), eyeAt({0, 0, -1})));
  EXPECT_TRUE(away(square(), eyeAt({50, 0, -1})));
  EXPECT_TRUE(away(square(), eyeAt({0.3, 0.2, -1e-6})));
  EXPECT_FALSE(away(square(), eyeAt({0, 0, 0})));
  EXPECT_FALSE(away(square(), eyeAt({3, 0, 0})));
  EXPECT_FALSE(away(square(), eyeAt({0, 0, 1e-9})));
}

TEST(FacingClusters, NothingTwoSidedTurnsAway) {
  EXPECT_FALSE(away(square(true), eyeAt({0, 0, -1})));
}

TEST(FacingClusters, NothingClosedTurnsAway) {
  EXPECT_FALSE(away(ball(), eyeAt({0, 0, -5})));
  EXPECT_TRUE(away(ball(), eyeAt({0, 0, 0})));  // from within, all of it does
}

TEST(FacingClusters, AMirroredNodeKeepsTheSideThatIsItsFront) {
  const std::array<double, 12> mirrored{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0};
  EXPECT_TRUE(away(square(), eyeAt({0, 0, 1}), mirrored));
  EXPECT_FALSE(away(square(), eyeAt({0, 0, -1}), mirrored));
}

TEST(FacingClusters, EveryEyeOfTheMotionBoundCounts) {
  EXPECT_TRUE(away(square(), eyeAt({0, 0, -1}, 0.99)));
  EXPECT_FALSE(away(square(), eyeAt({0, 0, -1}, 1.0)));
  const std::array<double, 12> small{0.1, 0, 0, 0, 0, 0.1, 0, 0, 0, 0, 0.1, 0};
  EXPECT_TRUE(away(square(), eyeAt({0, 0, -1}, 0.99), small));
  EXPECT_FALSE(away(square(), eyeAt({0, 0, -1}, 1.0), small));
}

TEST(FacingClusters, ParallelRaysAreAskedByDirection) {
  VolumeEye eye = eyeAt({0, 0, -1});
  eye.perspective = false;
  eye.along = {0, 0, 1};
  EXPECT_TRUE(away(square(), eye));
  eye.along = {0, 0.8, -0.6};
  EXPECT_FALSE(away(square(), eye));
  eye.along = {0, 1, 0};
  EXPECT_FALSE(away(square(), eye));
}

TEST(FacingClusters, FlatTransformsAreNotAsked) {
  EXPECT_FALSE(away(square(), eyeAt({0, 0, -1}), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0}));
  EXPECT_FALSE(away(square(), eyeAt({0, 0, -1}), {1, 0, 0, 0, 0, 1e-9, 1, 0, 0, 0, 1, 0}));
}

TEST(FacingClusters, TrianglesWithoutAreaDoNotTurnAway) {
  scenes::Triangles t = scenes::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  t.positions.insert(t.positions.end(), {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}});
  t.indices.insert(t.indices.end(), {4, 5, 6});
  EXPECT_FALSE(away(meshOf(t), eyeAt({0, 0, -1})));
}

struct Facing {
  std::uint64_t triangles = 0, regions = 0;
};

Facing facing(const Mesh& mesh, const ClusterRules& rules, bool hierarchy = true) {
  Facing out;
  std::vector<SheetSurface> runs;
  out.triangles =
      FacingClusters::of(mesh, rules)
          .appendFacing(mesh, *meshEye(kIdentity, eyeAt({0, 3, 40})), hierarchy, runs, out.regions);
  std::uint64_t in_runs = 0;
  for (const SheetSurface& run : runs) in_runs += run.triangle_count;
  EXPECT_EQ(in_runs, out.triangles);
  return out;
}

TEST(FacingClusters, LeaveOutNearlyHalfOfABall) {
  const Mesh mesh = ball(32);
  const Facing counts = facing(mesh, {});
  EXPECT_LT(10 * counts.triangles, 6 * mesh.triangles.size());
  EXPECT_GT(2 * counts.triangles, mesh.triangles.size());
}

TEST(FacingClusters, TheHierarchySavesMostOfTheWork) {
  const Mesh mesh = ball(96);
  const Facing from_top = facing(mesh, {}), leaves = facing(mesh, {}, false);
  EXPECT_LE(from_top.triangles, leaves.triangles);
  EXPECT_LT(2 * from_top.regions, leaves.regions);
}

TEST(FacingClusters, LikeNormalsMakeLargerRegions) {
  // Many small pyramids: triangles that are near each other face four ways.
  scenes::Triangles t;
  for (int i = 0; i < 400; ++i) {
    const glm::vec3 at(static_cast<float>(i % 20), static_cast<float>(i / 20), 0.0F);
    const auto first = static_cast<std::uint32_t>(t.positions.size());
    for (const glm::vec3 p : {glm::vec3(0, 0, 0), {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {.5F, .5F, 3}})
      t.positions.push_back(at + p);
    for (std::uint32_t side = 0; side < 4; ++side)
      t.indices.insert(t.indices.end(), {first + side, first + (side + 1) % 4, first + 4});
  }
  const Mesh mesh = meshOf(t);
  const Facing both = facing(mesh, {16, true, true}), place = facing(mesh, {16, true, false});
  EXPECT_LT(both.triangles, place.triangles);
}

/// 64 boards that face up, the eye between those in the middle, or higher than that.
Mesh shelf(float lower = 0.0F) {
  scenes::Triangles t;
  for (int i = 0; i < 64; ++i) {
    const float height = static_cast<float>(i * 37 % 64) - 28.5F - lower;
    scenes::append(t, scenes::quad({-1, height, 1}, {2, 0, 0}, {0, 0, -2}));
  }
  return meshOf(t);
}

TEST(FacingClusters, NearTrianglesMakeLargerRegions) {
  const Mesh mesh = shelf();
  const Facing both = facing(mesh, {4, true, true}), normal = facing(mesh, {4, false, true});
  EXPECT_EQ(both.triangles, 64U);
  EXPECT_GT(normal.triangles, 96U);
}

TEST(FacingClusters, AClusterIsFacingAsAWholeOnlyBeforeAllOfItsPlanes) {
  EXPECT_EQ(facing(shelf(16.0F), {4, true, true}).triangles, 96U);
}

TEST(FacingClusters, MoreRegionsThanAllowedDecideNothing) {
  const Mesh mesh = ball(96);
  const FacingClusters clusters = FacingClusters::of(mesh, {});
  const auto within = meshEye(kIdentity, eyeAt({0, 0, 0}));
  std::uint64_t all = 0, some = 0;
  EXPECT_TRUE(clusters.turnedAway(*within, false, kAllRegions, all));
  EXPECT_FALSE(clusters.turnedAway(*within, false, all - 1, some));
  EXPECT_LE(some, all);
  some = 0;
  EXPECT_FALSE(clusters.turnedAway(*within, false, 10, some));
  EXPECT_LE(some, 11U);
}

/// Front to +z at z = 0; glass with its front to -z at z = -2; and, with two sides, z = 0 again.
Mesh surfaces(bool with_third) {
  const scenes::Triangles up = scenes::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
  const scenes::Triangles down = scenes::quad({-1, -1, -2}, {0, 2, 0}, {2, 0, 0});
  std::vector<RawSurface> raw{{up.positions, up.indices, true, false},
                              {down.positions, down.indices, false, false}};
  if (with_third) raw.push_back({up.positions, up.indices, true, true});
  const Mesh mesh = makeMesh(raw);
  EXPECT_EQ(mesh.surfaces.size(), raw.size());
  return mesh;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> runsFrom(const Mesh& mesh,
                                                              const glm::dvec3& eye) {
  std::vector<SheetSurface> runs;
  std::uint64_t regions = 0;
  FacingClusters::of(mesh, {}).appendFacing(mesh, *meshEye(kIdentity, eyeAt(eye)), true, runs,
                                            regions);
  std::vector<std::pair<std::uint32_t, std::uint32_t>> out;
  for (const SheetSurface& run : runs) {
    EXPECT_EQ(run.double_sided, mesh.surfaces[run.first_triangle / 2].double_sided);
    out.emplace_back(run.first_triangle, run.triangle_count);
  }
  return out;
}

TEST(FacingClusters, EachSurfaceOfAMeshIsAskedByItself) {
  using Runs = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
  const glm::dvec3 between(0, 0, -1), below(0, 0, -3), above(0, 0, 1);
  const Mesh two = surfaces(false), three = surfaces(true);
  EXPECT_TRUE(away(two, eyeAt(between)));
  EXPECT_FALSE(away(two, eyeAt(below)));  // the glass does not
  EXPECT_FALSE(away(two, eyeAt(above)));
  EXPECT_EQ(runsFrom(two, between), Runs{});
  EXPECT_EQ(runsFrom(two, below), Runs{});  // which blocks nothing
  EXPECT_EQ(runsFrom(two, above), (Runs{{0, 2}}));
  EXPECT_FALSE(away(three, eyeAt(between)));
  EXPECT_EQ(runsFrom(three, between), (Runs{{4, 2}}));
  EXPECT_EQ(runsFrom(three, above), (Runs{{0, 2}, {4, 2}}));
}

TEST(FacingClusters, PointsAndLinesNeverTurnAway) {
  Mesh mesh = square();
  ASSERT_TRUE(away(mesh, eyeAt({0, 0, -1})));
  mesh.points_and_lines = 1;
  EXPECT_FALSE(away(mesh, eyeAt({0, 0, -1})));
}

TEST(FacingClusters, PartnersFollowTheirTriangles) {
  const Mesh mesh = ball(8);
  const FacingClusters clusters = FacingClusters::of(mesh, {});
  ASSERT_EQ(clusters.partners().size(), 3 * clusters.triangles().size());
  for (std::uint32_t h = 0; h < clusters.partners().size(); ++h) {
    const std::uint32_t p = clusters.partners()[h];
    ASSERT_EQ(clusters.partners()[p], h);
    EXPECT_EQ(clusters.triangles()[h / 3][h % 3], clusters.triangles()[p / 3][(p % 3 + 1) % 3]);
  }
}

}  // namespace
}  // namespace culld
