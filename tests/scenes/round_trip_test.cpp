// What is tested in memory is what a user can load: a model and its .glb are the same scene.
#include <gtest/gtest.h>

#include "culling/scene/gltf_loader.h"
#include "tests/scenes/city.h"
#include "tests/scenes/known_scenes.h"
#include "tests/scenes/random_scene.h"

namespace culld::scenes {
namespace {

SnapshotPtr loaded(const Model& model, const std::string& name) {
  auto scene = loadGltfBytes(toGlb(model), name);
  EXPECT_TRUE(scene.ok()) << scene.error().message;
  return scene.ok() ? std::move(scene).value() : toSnapshot({});
}

TEST(RoundTrip, HandMadeScenesAreTheSameFromAFile) {
  for (const KnownScene& known : knownScenes()) {
    EXPECT_EQ(loaded(known.model, known.name)->contentHash(), known.snapshot->contentHash())
        << known.name;
  }
}

TEST(RoundTrip, RandomScenesAreTheSameFromAFile) {
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    const Model model = randomModel(seed);
    EXPECT_EQ(loaded(model, "random")->contentHash(), toSnapshot(model)->contentHash())
        << "seed " << seed;
  }
}

/// Matrices are multiplied in another order, so places agree to a rounding.
TEST(RoundTrip, TheCityHasTheSameObjectsInTheSamePlaces) {
  const City city = generateCity({1, 20'000, 1});
  const SnapshotPtr file = loaded(city.model, "city"), memory = toSnapshot(city.model);
  ASSERT_EQ(file->objectCount(), memory->objectCount());
  EXPECT_EQ(file->triangleCount(), memory->triangleCount());
  EXPECT_TRUE(file->warnings().empty());
  for (ObjectId id = 0; id < memory->objectCount(); ++id) {
    const Instance &a = file->instance(id), &b = memory->instance(id);
    ASSERT_EQ(a.node, b.node);
    for (std::size_t i = 0; i < 12; ++i) {
      ASSERT_NEAR(a.world_from_mesh[i], b.world_from_mesh[i], 1e-9) << "object " << id;
    }
  }
}

}  // namespace
}  // namespace culld::scenes
