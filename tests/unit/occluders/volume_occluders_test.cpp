#include "culling/occluders/volume_occluders.h"

#include <gtest/gtest.h>

#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

constexpr std::size_t kTriangles = 20;  ///< of an L of walls

Mesh angle() {
  const std::vector<glm::vec2> corner{{0, 0}, {0, 2}, {1, 2}, {1, 1}, {2, 1}, {2, 0}};
  const scenes::Triangles shape = scenes::prism(corner, 0.0F, 1.0F);
  return makeMesh({{shape.positions, shape.indices, true, false}});
}

/// Two meshes that need hulls, of which the second stands for the larger object, and one that does
/// not.
SnapshotPtr threeMeshes() {
  SceneBuilder builder;
  builder.addInstance(builder.addMesh(angle()), scenes::kIdentity, 0);
  builder.addInstance(builder.addMesh(angle()), scenes::scaledAndMoved({3, 3, 3}, {9, 0, 0}), 1);
  scenes::Triangles boxes = scenes::box(glm::vec3(0), glm::vec3(1));
  scenes::append(boxes, scenes::box(glm::vec3(0), glm::vec3(4)), scenes::movedBy({3, 0, 0}));
  builder.addInstance(builder.addMesh(makeMesh({{boxes.positions, boxes.indices, true, false}})),
                      scenes::kIdentity, 2);
  return builder.finish();
}

TEST(VolumeOccluders, ArePiecesWhereThereAreSomeAndHullsElsewhere) {
  const SnapshotPtr scene = threeMeshes();
  ASSERT_EQ(scene->mesh(0).triangles.size(), kTriangles);
  const VolumeOccluders all = VolumeOccluders::of(*scene);
  EXPECT_EQ(all.countOf(0), 2U);
  EXPECT_EQ(all.countOf(1), 2U);
  ASSERT_EQ(all.countOf(2), 2U);
  EXPECT_EQ(all.size(), 6U);
  EXPECT_TRUE(all.occluder(1, 0).solid);
  EXPECT_FALSE(all.occluder(2, 0).solid);
  EXPECT_EQ(all.occluder(2, 0).box_mesh.max.x, 7.0);  // largest first
  EXPECT_EQ(all.occluder(2, 1).shape.vertices.size(), 8U);
  EXPECT_GT(all.bytes(), 0U);
}

TEST(VolumeOccluders, LookForHullsInLargeObjectsFirstAndNoLongerThanAllowed) {
  const SnapshotPtr scene = threeMeshes();
  const VolumeOccluders none = VolumeOccluders::of(*scene, 0);
  EXPECT_EQ(none.countOf(0) + none.countOf(1), 0U);
  EXPECT_EQ(none.countOf(2), 2U);
  const VolumeOccluders one = VolumeOccluders::of(*scene, 2 * kTriangles + 12);
  EXPECT_EQ(one.countOf(0), 0U);
  EXPECT_EQ(one.countOf(1), 2U);
}

}  // namespace
}  // namespace culld
