#include "culling/planner/overhang.h"

#include <gtest/gtest.h>

#include "culling/scene/scene_builder.h"
#include "tests/scenes/city.h"
#include "tests/scenes/model.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

SnapshotPtr sceneOf(const scenes::Triangles& triangles) {
  SceneBuilder builder;
  const MeshId mesh =
      builder.addMesh(makeMesh({{triangles.positions, triangles.indices, true, false}}));
  builder.addInstance(mesh, scenes::kIdentity, 0);
  return builder.finish();
}

scenes::Triangles boxesAt(const std::vector<glm::vec3>& places, float height) {
  scenes::Triangles all;
  for (const glm::vec3& at : places) {
    const scenes::Triangles box = scenes::box(at, at + glm::vec3(10.0F, height, 10.0F));
    scenes::append(all, box, scenes::kIdentity);
  }
  return all;
}

TEST(Overhang, IsNoneForAnEmptyScene) { EXPECT_EQ(overhangOf(*SceneBuilder().finish()), 0.0); }

TEST(Overhang, IsNoneForHousesThatStand) {
  EXPECT_EQ(overhangOf(*sceneOf(boxesAt({{0, 0, 0}, {30, 0, 0}, {0, 0, 30}, {30, 0, 30}}, 20))),
            0.0);
}

TEST(Overhang, IsTheShareThatFacesDownAboveTheGround) {
  const auto hanging = boxesAt({{0, 0, 0}, {30, 0, 0}, {0, 50, 0}, {30, 50, 0}}, 10);
  EXPECT_NEAR(overhangOf(*sceneOf(hanging)), 0.25, 0.05);
}

TEST(Overhang, IsNearlyHalfOfACave) {
  scenes::Triangles room = scenes::box(glm::vec3(-10), glm::vec3(10));
  for (std::size_t i = 0; i < room.indices.size(); i += 3) {
    std::swap(room.indices[i], room.indices[i + 1]);  // inside out
  }
  EXPECT_NEAR(overhangOf(*sceneOf(room)), 0.5, 1e-9);
}

TEST(Overhang, TellsFrontsOfMirroredObjects) {
  scenes::Triangles houses = boxesAt({{0, 0, 0}, {30, 0, 0}}, 20);
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(makeMesh({{houses.positions, houses.indices, true, false}}));
  builder.addInstance(mesh, {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, 0);
  EXPECT_EQ(overhangOf(*builder.finish()), 0.0);
}

}  // namespace
}  // namespace culld
