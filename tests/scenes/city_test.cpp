#include "tests/scenes/city.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

namespace culld::scenes {
namespace {

City town(std::uint32_t objects, std::uint64_t seed = 1) {
  return generateCity({seed, objects, 60});
}

TEST(City, HasExactlyTheObjectsAskedFor) {
  for (const std::uint32_t objects : {1'000U, 5'000U, 33'333U, 120'000U}) {
    EXPECT_EQ(town(objects).model.objectCount(), objects);
  }
}

TEST(City, IsNamedByItsSeed) {
  const std::vector<std::byte> once = toGlb(town(3'000).model);
  EXPECT_EQ(once, toGlb(town(3'000).model));
  EXPECT_NE(once, toGlb(town(3'000, 2).model));
}

TEST(City, TheSampleFitsIntoThirtyMegabytesAndSharesItsMeshes) {
  const City city = town(120'000);
  EXPECT_LT(toGlb(city.model).size(), 30'000'000U);
  EXPECT_LT(city.model.meshes.size(), 200U);
  const SnapshotPtr scene = toSnapshot(city.model);
  EXPECT_GT(scene->triangleCount(), 3'000'000U);
  EXPECT_EQ(scene->objectCount(), 120'000U);
  RecordProperty("triangles", std::to_string(scene->triangleCount()));
}

TEST(City, HasAllSortsOfMaterialsAndNodesThatGroup) {
  const City city = town(5'000);
  std::set<std::pair<Alpha, bool>> sorts;
  for (const ModelMesh& mesh : city.model.meshes) {
    for (const Part& part : mesh.parts) {
      const Material& m = city.model.materials[part.material];
      sorts.insert({m.alpha, m.double_sided});
    }
  }
  EXPECT_TRUE(sorts.count({Alpha::kOpaque, false}));
  EXPECT_TRUE(sorts.count({Alpha::kOpaque, true}));
  EXPECT_TRUE(sorts.count({Alpha::kMask, true}));
  EXPECT_TRUE(sorts.count({Alpha::kBlend, true}));
  EXPECT_GT(city.model.nodes.size(), city.model.objectCount());
}

TEST(City, NothingIsUnboundedMirroredOrEmpty) {
  const SnapshotPtr scene = toSnapshot(town(5'000).model);
  for (ObjectId id = 0; id < scene->objectCount(); ++id) {
    EXPECT_TRUE(scene->instance(id).active());
    EXPECT_FALSE(scene->instance(id).always_kept);
    EXPECT_FALSE(mirrors(scene->instance(id).world_from_mesh));
  }
}

/// Not within the box of any object, let alone inside one. Hills begin at height 0 where the city
/// ends, so their boxes say nothing about the outermost street.
TEST(City, CamerasAreClearOfEverything) {
  for (const std::uint32_t objects : {1'000U, 20'000U, 120'000U}) {
    const City city = town(objects);
    const SnapshotPtr scene = toSnapshot(city.model);
    ASSERT_EQ(city.cameras.size(), 60U);
    for (const CameraSpec& spec : city.cameras) {
      const Result<Camera> camera = toCamera(spec);
      ASSERT_TRUE(camera.ok()) << camera.error().message;
      const glm::dvec3 eye = camera.value().origin_world;
      for (ObjectId id = 0; id < scene->objectCount(); ++id) {
        const std::string& name = city.model.meshes[scene->instance(id).mesh].name;
        if (name == "hill") continue;
        const Box& b = scene->instance(id).bounds_world;
        const bool clear = eye.x < b.min.x - 0.3 || eye.x > b.max.x + 0.3 ||
                           eye.y < b.min.y - 0.3 || eye.y > b.max.y + 0.3 ||
                           eye.z < b.min.z - 0.3 || eye.z > b.max.z + 0.3;
        EXPECT_TRUE(clear) << "object " << id << " at " << eye.x << " " << eye.y << " " << eye.z;
      }
    }
  }
}

TEST(City, TheWalkTurnsCornersAndTheFlightLeavesTheGround) {
  const City city = town(120'000);
  std::set<int> headings;
  double highest = 0;
  for (const CameraSpec& spec : city.cameras) {
    const auto& look = std::get<LookAt>(spec.pose);
    const glm::dvec3 ahead = look.target - look.eye;
    if (look.eye.y < 1.8)
      headings.insert(static_cast<int>(std::lround(4 * std::atan2(ahead.z, ahead.x) / 3.15)));
    highest = std::max(highest, look.eye.y);
  }
  EXPECT_GE(headings.size(), 2U);
  EXPECT_GT(highest, 50.0);
}

}  // namespace
}  // namespace culld::scenes
