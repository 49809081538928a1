#include "culling/occluders/strict_solids.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <numbers>
#include <random>

#include "culling/occluders/solid_boxes.h"
#include "culling/occluders/voxel_planes.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/random.h"
#include "tests/scenes/rounds.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

using scenes::Triangles;

struct Voxelized {
  SnapshotPtr scene;
  VoxelGrid grid;
  SolidVoxels voxels;
};

Triangles insideOut(Triangles t) {
  for (std::size_t i = 0; i < t.indices.size(); i += 3) std::swap(t.indices[i], t.indices[i + 1]);
  return t;
}

class StrictSolids : public ::testing::Test {
 protected:
  void add(const Triangles& t, const scenes::Rows& rows = scenes::kIdentity,
           bool double_sided = false, bool blocks = true) {
    builder_.addInstance(
        builder_.addMesh(makeMesh({{t.positions, t.indices, blocks, double_sided}})), rows,
        nodes_++);
  }
  Voxelized voxelize(const VoxelLimits& limits = {1U << 20U, 32, 40}) {
    const SnapshotPtr scene = builder_.finish();
    const SolidParts parts = SolidParts::of(*scene);
    Box world{glm::dvec3(-1.0), glm::dvec3(1.0)};
    for (const SolidPart& part : parts.parts()) world.grow(part.box_world);
    VoxelGrid grid = voxelGridFor(parts, world, limits);
    SolidVoxels voxels = strictSolids(parts, grid, voxelSnap(world), 100'000'000);
    return {scene, std::move(grid), std::move(voxels)};
  }

  SceneBuilder builder_;
  std::uint32_t nodes_ = 0;
};

double volumeOf(const Voxelized& v) {
  double sum = 0.0;
  for (const VoxelRange& range : solidBoxes(v.grid, v.voxels.solid, 1U << 20U)) {
    const Box box = v.grid.boundsOf(range);
    sum += (box.max.x - box.min.x) * (box.max.y - box.min.y) * (box.max.z - box.min.z);
  }
  return sum;
}

/// How many times an object's blocking surface winds around a point; orientation as in its mesh.
double windingAround(const SceneSnapshot& scene, ObjectId id, const glm::dvec3& p) {
  const Instance& instance = scene.instance(id);
  const Mesh& mesh = scene.mesh(instance.mesh);
  const auto& m = instance.world_from_mesh;
  const glm::dmat3 turn(m[0], m[4], m[8], m[1], m[5], m[9], m[2], m[6], m[10]);
  const double sign = glm::determinant(turn) < 0.0 ? -1.0 : 1.0;
  double sum = 0.0;
  for (const auto& t : mesh.triangles) {
    glm::dvec3 v[3];
    for (std::size_t c = 0; c < 3; ++c) {
      v[c] = glm::normalize(turn * glm::dvec3(mesh.positions[t[c]]) +
                            glm::dvec3(m[3], m[7], m[11]) - p);
    }
    sum +=
        2.0 * std::atan2(glm::dot(v[0], glm::cross(v[1], v[2])),
                         1.0 + glm::dot(v[0], v[1]) + glm::dot(v[1], v[2]) + glm::dot(v[2], v[0]));
  }
  return sign * sum / (4.0 * std::numbers::pi);
}

TEST_F(StrictSolids, AThinWallFillsTheVoxelsThatAreCutAlongIt) {
  add(scenes::box({-5, 0, 0}, {5, 3, 0.01F}));
  const Voxelized v = voxelize();
  EXPECT_NEAR(volumeOf(v), 10 * 3 * 0.01F, 1e-6);
  EXPECT_EQ(v.voxels.unclear.count(), 0U);
  EXPECT_EQ(solidBoxes(v.grid, v.voxels.solid, 100).size(), 1U);
  ASSERT_EQ(v.voxels.makers.size(), 1U);
}

TEST_F(StrictSolids, WithoutPlanesAlongItAThinWallIsNotSolid) {
  add(scenes::box({-5, 0, 0}, {5, 3, 0.01F}));
  const Voxelized v = voxelize({1U << 20U, 0, 40});
  EXPECT_EQ(v.voxels.solid.count(), 0U);
  EXPECT_TRUE(v.voxels.makers.empty());
}

TEST_F(StrictSolids, WallsSideBySideAreOneSolidUpToRounding) {
  for (int i = 0; i < 5; ++i) {  // 0.1 * 3 + i is rounded: their faces meet within an ulp or two
    add(scenes::box({0, 0, 0}, {1, 3, 0.25F}), scenes::movedBy({0.1 * 3 + i, 0.0, 0.0}));
  }
  const Voxelized v = voxelize();
  const auto boxes = solidBoxes(v.grid, v.voxels.solid, 100);
  ASSERT_EQ(boxes.size(), 1U);
  EXPECT_NEAR(v.grid.boundsOf(boxes[0]).max.x - v.grid.boundsOf(boxes[0]).min.x, 5.0, 1e-6);
}

TEST_F(StrictSolids, AWallTurnedByARoundedRightAngleIsFilledToo) {
  const double c = std::cos(0.5 * std::numbers::pi);  // 6e-17: its faces are flat up to rounding
  add(scenes::box({-5, 0, 1}, {5, 3, 1.01F}), {c, 0, 1, 0, 0, 1, 0, 0, -1, 0, c, 0});
  EXPECT_NEAR(volumeOf(voxelize()), 10 * 3 * (1.01F - 1.0F), 1e-6);
}

TEST_F(StrictSolids, ASlitBetweenTwoWallsStaysOpenHoweverNarrow) {
  for (const float slit : {0.1F, 1e-3F, 1e-6F}) {
    add(scenes::box({-2, 0, 0}, {-slit, 2, 1}));
    add(scenes::box({0, 0, 0}, {2, 2, 1}));
    const Voxelized v = voxelize();
    EXPECT_GT(v.voxels.solid.count(), 0U);
    const glm::dvec3 middle(-0.5 * double{slit}, 1.0, 0.5);
    EXPECT_FALSE(v.voxels.solid.every(v.grid.touching({middle, middle}))) << slit;
    for (const VoxelRange& range : solidBoxes(v.grid, v.voxels.solid, 1000)) {
      const Box box = v.grid.boundsOf(range);
      EXPECT_FALSE(box.min.x < middle.x && middle.x < box.max.x) << slit;
    }
  }
}

TEST_F(StrictSolids, ASlitStaysOpenWhateverElseIsFarAway) {
  for (const float slit : {1e-4F, 1e-2F, 0.1F}) {
    add(scenes::box({-300, -50, -50}, {-slit, 50, 50}));
    add(scenes::box({0, -50, -50}, {300, 50, 50}));
    add(scenes::box({100, -60, -60}, {200, 60, 60}));  // cuts the one beside the slit in two
    add(scenes::box(glm::vec3(-1), glm::vec3(1)), {1e12, 0, 0, 0, 0, 1e12, 0, 0, 0, 0, 1e12, 1e13});
    const Voxelized v = voxelize();
    const glm::dvec3 middle(-0.5 * double{slit}, 1.0, 0.5);
    EXPECT_FALSE(v.voxels.solid.every(v.grid.touching({middle, middle}))) << slit;
    builder_ = SceneBuilder();
  }
}

/// Where in a voxel its row along x is looked along, as strict_solids.cpp has it.
constexpr float kRowY = 0.53125F, kRowZ = 0.40625F;

/// The surface of a U of blocks, two arms on a base, closed and without T-junctions. The faces that
/// look into it are fans around the place where the one row between the arms goes along x.
Triangles armsAround(const VoxelGrid& grid, const glm::vec3& row) {
  Triangles t;
  const auto holds = [](int x, int z) {
    return z == 0 ? x >= 0 && x < 3 : z == 1 && (x == 0 || x == 2);
  };
  const auto corner = [&](int x, int y, int z) {
    return glm::vec3(grid.planes(0)[static_cast<std::size_t>(x)],
                     grid.planes(1)[static_cast<std::size_t>(y)],
                     grid.planes(2)[static_cast<std::size_t>(z)]);
  };
  const auto triangle = [&](glm::vec3 a, glm::vec3 b, glm::vec3 c, const glm::vec3& out) {
    if (glm::dot(glm::cross(b - a, c - a), out) < 0.0F) std::swap(b, c);
    for (const glm::vec3& p : {a, b, c}) {
      t.indices.push_back(static_cast<std::uint32_t>(t.positions.size()));
      t.positions.push_back(p);
    }
  };
  const auto face = [&](const std::array<glm::vec3, 4>& p, const glm::vec3& out) {
    const bool inner = p[0].x == p[2].x && p[0].x > grid.planes(0)[0] && p[0].x < grid.planes(0)[3];
    const glm::vec3 middle = inner ? glm::vec3(p[0].x, row.y, row.z) : 0.5F * (p[0] + p[2]);
    for (std::size_t i = 0; i < 4; ++i) triangle(p[i], p[(i + 1) % 4], middle, out);
  };
  for (int z = 0; z < 2; ++z) {
    for (int x = 0; x < 3; ++x) {
      if (!holds(x, z)) continue;
      for (const int y : {0, 1}) {
        face({corner(x, y, z), corner(x + 1, y, z), corner(x + 1, y, z + 1), corner(x, y, z + 1)},
             {0, y == 0 ? -1 : 1, 0});
      }
      for (const int side : {0, 1}) {
        const int u = x + side, w = z + side;
        if (!holds(x + 2 * side - 1, z)) {
          face({corner(u, 0, z), corner(u, 1, z), corner(u, 1, z + 1), corner(u, 0, z + 1)},
               {2 * side - 1, 0, 0});
        }
        if (!holds(x, z + 2 * side - 1)) {
          face({corner(x, 0, w), corner(x + 1, 0, w), corner(x + 1, 1, w), corner(x, 1, w)},
               {0, 0, 2 * side - 1});
        }
      }
    }
  }
  return t;
}

TEST_F(StrictSolids, ARowThatMeetsCornersProvesNothing) {
  const VoxelGrid grid({std::vector<double>{0, 2, 4, 6}, {0, 8}, {0, 2, 10}});
  // Beside the row's place the arms are solid.
  for (const float beside : {0.0F, 0.25F}) {
    add(armsAround(grid, {0, 8 * kRowY + beside, 2 + 8 * kRowZ + beside}));
    const SnapshotPtr scene = builder_.finish();
    const SolidParts parts = SolidParts::of(*scene);
    ASSERT_EQ(parts.parts().size(), 1U);
    const SolidVoxels voxels = strictSolids(parts, grid, 1e-12, 100'000'000);
    EXPECT_TRUE(voxels.solid.every({{0, 0, 0}, {3, 1, 1}}));
    EXPECT_FALSE(voxels.solid.test({1, 0, 1})) << "between the arms";
    EXPECT_EQ(voxels.solid.test({0, 0, 1}), beside != 0.0F);
    builder_ = SceneBuilder();
  }
}

TEST_F(StrictSolids, APartWhosePlaceIsUncertainIsLeftOut) {
  const float far = 0x1p30F;
  const Triangles box = scenes::box(glm::vec3(far), glm::vec3(far + 1024.0F));
  add(box, {1, 0, 0, -double{far}, 0, 1, 0, -double{far}, 0, 0, 1, -double{far}});
  EXPECT_TRUE(
      voxelize().voxels.makers.empty());  // up to 2^-19 m off, where planes are 2^-36 m apart
  builder_ = SceneBuilder();
  add(scenes::box(glm::vec3(0.0F), glm::vec3(1024.0F)));
  EXPECT_FALSE(voxelize().voxels.makers.empty());
}

TEST_F(StrictSolids, APinholeACrackAndATJunctionOpenAPart) {
  Triangles pinhole = scenes::box(glm::vec3(0), glm::vec3(2));
  pinhole.indices.resize(pinhole.indices.size() - 3);
  add(pinhole);
  Triangles crack = scenes::box(glm::vec3(0), glm::vec3(2));
  crack.positions.push_back(crack.positions[crack.indices[0]] + glm::vec3(0, 0, 1e-6F));
  crack.indices[0] = static_cast<std::uint32_t>(crack.positions.size() - 1);
  add(crack, scenes::movedBy({5, 0, 0}));
  Triangles junction = scenes::box(glm::vec3(0), glm::vec3(2));
  {  // one triangle becomes two that meet on an edge; its neighbour there is not split
    const std::uint32_t a = junction.indices[0], b = junction.indices[1], c = junction.indices[2];
    const auto m = static_cast<std::uint32_t>(junction.positions.size());
    junction.positions.push_back(0.5F * (junction.positions[a] + junction.positions[b]));
    junction.indices[1] = m;
    for (const std::uint32_t i : {m, b, c}) junction.indices.push_back(i);
  }
  add(junction, scenes::movedBy({10, 0, 0}));
  Triangles flipped = scenes::box(glm::vec3(0), glm::vec3(2));
  std::swap(flipped.indices[0], flipped.indices[1]);
  add(flipped, scenes::movedBy({15, 0, 0}));
  add(scenes::box(glm::vec3(0), glm::vec3(2)), scenes::movedBy({20, 0, 0}), false, false);
  EXPECT_EQ(voxelize().voxels.solid.count(), 0U);
}

TEST_F(StrictSolids, WhatFacesInwardsIsSolidOnlyIfItBlocksFromBothSides) {
  add(insideOut(scenes::box(glm::vec3(0), glm::vec3(2))));
  EXPECT_EQ(voxelize().voxels.solid.count(), 0U);
  add(insideOut(scenes::box(glm::vec3(0), glm::vec3(2))), scenes::kIdentity, true);
  EXPECT_NEAR(volumeOf(voxelize()), 8.0, 1e-6);
}

TEST_F(StrictSolids, AShellIsSolidInItsWallOnlyAndClearInside) {
  Triangles shell = scenes::box(glm::vec3(-4), glm::vec3(4));
  scenes::append(shell, insideOut(scenes::box(glm::vec3(-3), glm::vec3(3))));
  add(shell);
  const Voxelized v = voxelize();
  // Two parts, each closed by itself: seen alone, the outer one is solid all through, as from
  // outside of it nothing in it can be seen.
  EXPECT_NEAR(volumeOf(v), 512.0, 1e-3);
  const VoxelRange middle = v.grid.touching({glm::dvec3(0.0), glm::dvec3(0.0)});
  EXPECT_TRUE(v.voxels.solid.every(middle));
}

/// Random closed bodies, turned, scaled, mirrored, inside out, through each other: wherever a voxel
/// is called solid some body winds around it, and where an eye may be no maker does.
TEST_F(StrictSolids, AttackEveryPointOfASolidVoxelIsWithinABody) {
  std::uint64_t points = 0;
  for (std::uint64_t seed = 1; seed <= scenes::rounds(40); ++seed) {
    std::mt19937_64 random(seed);
    scenes::Random shapes(seed);
    const auto uniform = [&](double a, double b) {
      return std::uniform_real_distribution<double>(a, b)(random);
    };
    std::vector<bool> two_sided;
    const double far = seed % 4 == 0 ? 1e6 : 0.0;
    for (int i = 0; i < 6; ++i) {
      Triangles t;
      switch (random() % 4) {
        case 0:
          t = scenes::ball(5, 0.5, shapes);
          break;
        case 1:
          t = scenes::torus(9, 7, 1.0F, 0.6F);
          break;
        case 2:
          t = scenes::prism(scenes::regularFootprint(5, 1.0F), -1, 1);
          break;
        default:
          t = scenes::box(glm::vec3(-1), glm::vec3(1));
      }
      if (random() % 4 == 0) t = insideOut(t);
      scenes::Rows rows = scenes::kIdentity;
      const bool upright = random() % 2 == 0;
      for (std::size_t r = 0; r < 3; ++r) {
        for (std::size_t c = 0; c < 3; ++c) {
          rows[4 * r + c] = r == c ? uniform(0.5, 2.0) : (upright ? 0.0 : uniform(-0.7, 0.7));
        }
        rows[4 * r + 3] = uniform(-3, 3) + far;
      }
      if (random() % 3 == 0) {
        for (std::size_t r = 0; r < 3; ++r) rows[4 * r] = -rows[4 * r];
      }
      two_sided.push_back(random() % 3 == 0);
      add(t, rows, two_sided.back());
    }
    const SnapshotPtr scene = builder_.finish();
    const SolidParts parts = SolidParts::of(*scene);
    Box world;
    for (const SolidPart& part : parts.parts()) world.grow(part.box_world);
    const VoxelGrid grid = voxelGridFor(parts, world, {1U << 18U, 24, 30});
    const SolidVoxels voxels = strictSolids(parts, grid, voxelSnap(world), 100'000'000);
    const Voxel counts = grid.counts();
    for (int k = 0; k < 3000; ++k) {
      const Voxel at{static_cast<std::uint32_t>(random() % counts[0]),
                     static_cast<std::uint32_t>(random() % counts[1]),
                     static_cast<std::uint32_t>(random() % counts[2])};
      const bool solid = voxels.solid.test(at);
      if (!solid && voxels.unclear.test(at)) continue;
      const Box box = grid.boundsOf({at, {at[0] + 1, at[1] + 1, at[2] + 1}});
      const glm::dvec3 size = box.max - box.min;
      if (std::min({size.x, size.y, size.z}) < 1e-4) continue;  // too thin for this judge's doubles
      const glm::dvec3 p = box.min + size * glm::dvec3(uniform(0.05, 0.95), uniform(0.05, 0.95),
                                                       uniform(0.05, 0.95));
      bool within = false;
      for (ObjectId id = 0; id < 6; ++id) {
        const double w = std::round(windingAround(*scene, id, p));
        const bool inside = w >= 1.0 || (two_sided[id] && w != 0.0);
        within = within || inside;
        const bool maker = std::any_of(voxels.makers.begin(), voxels.makers.end(),
                                       [&](const SolidMaker& m) { return m.object == id; });
        EXPECT_FALSE(!solid && maker && inside) << seed;
      }
      EXPECT_TRUE(within || !solid) << seed;
      ++points;
    }
  }
  EXPECT_GT(points, scenes::rounds(40) * 500);
}

TEST_F(StrictSolids, WorkHasALimitAndWhatIsFoundByThenStands) {
  for (int i = 0; i < 40; ++i) {
    add(scenes::box(glm::vec3(0), glm::vec3(2)), scenes::movedBy({3.0 * i, 0, 0}));
  }
  const SnapshotPtr scene = builder_.finish();
  const SolidParts parts = SolidParts::of(*scene);
  Box world;
  for (const SolidPart& part : parts.parts()) world.grow(part.box_world);
  const VoxelGrid grid = voxelGridFor(parts, world, {});
  const SolidVoxels few = strictSolids(parts, grid, voxelSnap(world), 5'000);
  const SolidVoxels all = strictSolids(parts, grid, voxelSnap(world), 100'000'000);
  EXPECT_FALSE(few.complete);
  EXPECT_TRUE(all.complete);
  EXPECT_LT(few.makers.size(), all.makers.size());
  EXPECT_EQ(all.makers.size(), 40U);
}

}  // namespace
}  // namespace culld
