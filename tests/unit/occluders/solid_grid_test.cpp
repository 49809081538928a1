#include "culling/occluders/solid_grid.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

/// Boxes from (low) with a size.
class Boxes {
 public:
  Boxes() : cube_(addCube()) {}
  void add(const glm::dvec3& low, const glm::dvec3& size) {
    builder_.addInstance(cube_, {size.x, 0, 0, low.x, 0, size.y, 0, low.y, 0, 0, size.z, low.z},
                         node_++);
  }
  SnapshotPtr scene() { return builder_.finish(); }

 private:
  MeshId addCube() {
    const scenes::Triangles t = scenes::box(glm::vec3(0), glm::vec3(1));
    return builder_.addMesh(makeMesh({{t.positions, t.indices, true, false}}));
  }
  SceneBuilder builder_;
  MeshId cube_;
  std::uint32_t node_ = 0;
};

SnapshotPtr lattice() {
  Boxes boxes;
  for (int i = 0; i < 1000; ++i) {
    boxes.add(glm::dvec3(i % 10, i / 10 % 10, i / 100), glm::dvec3(i % 10 < 5 ? 0.9 : 0.1));
  }
  return boxes.scene();
}

TEST(SolidGrid, HoldsEachObjectInEveryCellThatItsBoxLiesIn) {
  const SnapshotPtr scene = lattice();
  const SolidGrid grid = SolidGrid::of(*scene, OccluderSet::of(*scene), 1.0);
  EXPECT_TRUE(grid.loose().empty());
  EXPECT_GT(grid.size(), 300U);
  EXPECT_LE(grid.size(), 1300U);
  const auto holds = [&](const glm::dvec3& p, ObjectId id) {
    const auto ids = grid.objects(grid.indexOf(grid.cellAt(p)));
    return std::find(ids.begin(), ids.end(), id) != ids.end();
  };
  for (ObjectId id = 0; id < scene->objectCount(); ++id) {
    const Box& box = scene->instance(id).bounds_world;
    EXPECT_TRUE(holds(box.min, id));
    EXPECT_TRUE(holds(box.max, id));
    EXPECT_TRUE(holds(0.5 * (box.min + box.max), id));
  }
}

TEST(SolidGrid, IsMoreSolidWhereLargerThingsStand) {
  const SnapshotPtr scene = lattice();
  const SolidGrid grid = SolidGrid::of(*scene, OccluderSet::of(*scene), 1.0);
  const auto solidity = [&](const glm::dvec3& p) {
    return grid.solidity(grid.indexOf(grid.cellAt(p)));
  };
  EXPECT_GT(solidity({2.5, 4.5, 4.5}), 0.5F);
  EXPECT_LT(solidity({7.5, 4.5, 4.5}), 0.2F);
}

TEST(SolidGrid, IsNotStretchedByAFewThingsFarAway) {
  Boxes boxes;
  for (int i = 0; i < 1000; ++i) boxes.add(glm::dvec3(i % 10, i / 10 % 10, i / 100), glm::dvec3(1));
  boxes.add(glm::dvec3(1e12), glm::dvec3(1));
  const SnapshotPtr scene = boxes.scene();
  const SolidGrid grid = SolidGrid::of(*scene, OccluderSet::of(*scene), 1.0);
  EXPECT_TRUE(grid.contains({5, 5, 5}));
  EXPECT_FALSE(grid.contains({20, 5, 5}));
  const auto last = grid.objects(grid.indexOf(grid.cellAt(glm::dvec3(1e12))));
  EXPECT_EQ(std::count(last.begin(), last.end(), 1000U), 1);
}

TEST(SolidGrid, KeepsLooseWhatLiesInTooManyCellsOrWasEdited) {
  Boxes boxes;
  for (int i = 0; i < 1000; ++i) {
    boxes.add(glm::dvec3(i % 10, i / 10 % 10, i / 100), glm::dvec3(0.5));
  }
  boxes.add(glm::dvec3(0), glm::dvec3(10));
  const SnapshotPtr scene = boxes.scene();
  const SolidGrid grid = SolidGrid::of(*scene, OccluderSet::of(*scene), 1.0);
  EXPECT_EQ(std::vector<ObjectId>(grid.loose().begin(), grid.loose().end()),
            (std::vector<ObjectId>{1000}));
  const SolidGrid next = grid.edited(std::vector<ObjectId>{7, 3, 1000});
  EXPECT_EQ(std::vector<ObjectId>(next.loose().begin(), next.loose().end()),
            (std::vector<ObjectId>{3, 7, 1000}));
  EXPECT_EQ(next.size(), grid.size());
}

TEST(SolidGrid, IsOneCellForNothing) {
  const SnapshotPtr scene = SceneBuilder().finish();
  const SolidGrid grid = SolidGrid::of(*scene, OccluderSet::of(*scene), 1.0);
  EXPECT_EQ(grid.size(), 1U);
  EXPECT_TRUE(grid.objects(0).empty());
}

}  // namespace
}  // namespace culld
