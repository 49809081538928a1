// The hand-made and random scenes that all methods are tested with, under the oracle itself.
#include <gtest/gtest.h>

#include <algorithm>
#include <iterator>

#include "culling/oracle/oracle.h"
#include "tests/scenes/known_scenes.h"
#include "tests/scenes/random_scene.h"

namespace culld {
namespace {

using Ids = std::vector<ObjectId>;

Ids common(const Ids& a, const Ids& b) {
  Ids both;
  std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(both));
  return both;
}

TEST(OracleOnKnownScenes, SeesWhatMustBeVisibleAndNothingThatIsHiddenOrOutside) {
  for (const scenes::KnownScene& known : scenes::knownScenes()) {
    SCOPED_TRACE(known.name);
    const auto oracle = Oracle::build(known.snapshot);
    ASSERT_TRUE(oracle.ok());
    const auto camera = scenes::toCamera(known.camera);
    ASSERT_TRUE(camera.ok());
    const auto answer =
        oracle.value()->look(camera.value(), {.max_samples = 50'000, .rays_per_object = 64});
    ASSERT_TRUE(answer.ok());
    const Ids& found = answer.value().visible;
    EXPECT_EQ(common(found, known.can_be_hidden), Ids{});
    EXPECT_EQ(common(found, known.outside), Ids{});
    EXPECT_EQ(common(found, known.must_be_visible), known.must_be_visible);
  }
}

TEST(OracleOnRandomScenes, AnswersEveryCameraWithSomethingSomewhere) {
  std::size_t visible = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const SnapshotPtr scene = scenes::randomScene(seed);
    const auto oracle = Oracle::build(scene);
    ASSERT_TRUE(oracle.ok());
    for (scenes::CameraSpec& spec : scenes::randomCameras(seed, *scene, 6)) {
      spec.image = {64, 36};
      const auto camera = scenes::toCamera(spec);
      ASSERT_TRUE(camera.ok()) << spec.what;
      const auto answer = oracle.value()->look(camera.value());
      ASSERT_TRUE(answer.ok());
      EXPECT_TRUE(std::is_sorted(answer.value().visible.begin(), answer.value().visible.end()));
      visible += answer.value().visible.size();
    }
  }
  EXPECT_GT(visible, 500U);
}

}  // namespace
}  // namespace culld
