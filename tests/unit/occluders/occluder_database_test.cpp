#include "culling/occluders/occluder_database.h"

#include <gtest/gtest.h>

#include "culling/scene/edit.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

Mesh meshOf(const scenes::Triangles& t, bool blocks = true) {
  return makeMesh({{t.positions, t.indices, blocks, false}});
}

scenes::Triangles slantedSliver() { return {{{0, 0, 0}, {1, 1, 1}, {1.02F, 1, 1}}, {0, 1, 2}}; }

/// A wall with a clock on it and a chair before it, and one object for each other rule.
class Room {
 public:
  enum Id : ObjectId { kWall, kClock, kChair, kCrumb, kBall, kSliver, kGlass, kPillar, kObjects };

  Room() {
    scenes::Random random(1);
    SceneBuilder builder;
    const MeshId cube = builder.addMesh(meshOf(scenes::box(glm::vec3(0), glm::vec3(1))));
    const MeshId ball = builder.addMesh(meshOf(scenes::ball(40, 0.1, random)));
    const MeshId sliver = builder.addMesh(meshOf(slantedSliver()));
    const MeshId glass = builder.addMesh(meshOf(scenes::box(glm::vec3(0), glm::vec3(1)), false));
    std::uint32_t node = 0;
    const auto add = [&](MeshId mesh, const glm::dvec3& at, const glm::dvec3& size) {
      builder.addInstance(mesh, {size.x, 0, 0, at.x, 0, size.y, 0, at.y, 0, 0, size.z, at.z},
                          node++);
    };
    add(cube, {0, 0, 0}, {6, 3, 0.2});
    add(cube, {2, 2, 0.19}, {0.8, 0.8, 0.1});  // sticks out of the wall by 9 cm
    add(cube, {2, 0, 0.5}, {1, 1, 1});
    add(cube, {3, 0, 2}, {0.01, 0.01, 0.01});
    add(ball, {9, 0, 0}, {1, 1, 1});
    add(sliver, {0, 0, 5}, {2, 2, 2});
    add(glass, {0, 0, 7}, {1, 1, 1});
    add(cube, {5, 0, 5}, {0.5, 3, 0.5});
    scene = builder.finish();
    bvh = WideBvh::of(*scene);
    set = OccluderSet::of(*scene);
  }

  OccluderDatabase database(const OccluderRules& rules = {}) const {
    return OccluderDatabase::of(*scene, bvh, set, rules);
  }

  SnapshotPtr scene;
  WideBvh bvh;
  OccluderSet set;
};

TEST(OccluderDatabase, TakesWhatIsLargeSimpleAndSolid) {
  const Room room;
  const OccluderDatabase database = room.database();
  for (const ObjectId id : {Room::kWall, Room::kChair, Room::kPillar}) {
    EXPECT_TRUE(database.holds(id)) << id;
  }
  const OccluderTally tally = database.tally();
  EXPECT_EQ(tally.taken, 3U);
  EXPECT_EQ(tally.not_blocking, 1U);
  EXPECT_EQ(tally.small, 1U);
  EXPECT_EQ(tally.detailed, 1U);
  EXPECT_EQ(tally.ill_shaped, 1U);
  EXPECT_EQ(tally.redundant, 1U);
  EXPECT_GT(database.bytes(), 0U);
}

TEST(OccluderDatabase, TakesWhatARuleLeftOutOnceTheRuleIsOff) {
  const Room room;
  EXPECT_TRUE(room.database({.least_size = 0.0}).holds(Room::kCrumb));
  EXPECT_TRUE(room.database({.most_polygons = 0}).holds(Room::kBall));
  EXPECT_TRUE(room.database({.least_fill = 0.0}).holds(Room::kSliver));
  EXPECT_TRUE(room.database({.leave_redundant = false}).holds(Room::kClock));
  EXPECT_FALSE(room.database({0.0, 0, 0.0, false}).holds(Room::kGlass));  // never
}

TEST(OccluderDatabase, JudgesEditedObjectsAnew) {
  const Room room;
  OccluderDatabase database = room.database();
  // The clock comes off the wall; the chair goes.
  const auto edits = applyEdits(
      room.scene,
      std::vector<Edit>{MoveObject{Room::kClock, {1, 0, 0, 20, 0, 1, 0, 0, 0, 0, 1, 0}},
                        RemoveObject{Room::kChair},
                        AddInstance{Room::kPillar, {1, 0, 0, 30, 0, 1, 0, 0, 0, 0, 1, 0}}});
  ASSERT_TRUE(edits.ok());
  const SnapshotPtr next = edits.value().snapshot;
  const WideBvh bvh = room.bvh.edited(*next, edits.value().changed);
  database = database.edited(*next, bvh, room.set, edits.value().changed);
  EXPECT_TRUE(database.holds(Room::kClock));
  EXPECT_FALSE(database.holds(Room::kChair));
  EXPECT_TRUE(database.holds(Room::kObjects));  // the pillar that was added
  EXPECT_TRUE(database.holds(Room::kWall));
}

TEST(OccluderDatabase, EndsSoonWhereEverythingLiesOnEverything) {
  SceneBuilder builder;
  const MeshId cube = builder.addMesh(meshOf(scenes::box(glm::vec3(0), glm::vec3(1))));
  for (std::uint32_t i = 0; i < 50'000; ++i) builder.addInstance(cube, scenes::kIdentity, i);
  const SnapshotPtr scene = builder.finish();
  const OccluderDatabase database =
      OccluderDatabase::of(*scene, WideBvh::of(*scene), OccluderSet::of(*scene), {});
  EXPECT_EQ(database.tally().taken, 50'000U);  // none is the larger one
}

}  // namespace
}  // namespace culld
