// 1 000 random scenes made to break cullers, each seen by several cameras: no method may lack an
// object that the oracle sees, and every SIMD target must give the same bytes.
#include <gtest/gtest.h>

#include <optional>

#include "culling/core/simd.h"
#include "tests/scenes/random_scene.h"
#include "tests/scenes/rounds.h"
#include "tests/soundness/judge.h"

namespace culld {
namespace {

constexpr std::uint64_t kScenes = scenes::rounds(1000);
constexpr std::size_t kCamerasPerScene = 3;

struct Tally {
  std::size_t looks = 0, visible = 0, missed = 0, frustum = 0, raster = 0;
};

void judgeScene(std::uint64_t seed, Tally& tally) {
  const SnapshotPtr scene = scenes::randomScene(seed);
  auto oracle = Oracle::build(scene);
  ASSERT_TRUE(oracle.ok()) << oracle.error().message;
  std::vector<PreparedMethod> methods = prepareAll(scene);
  for (const scenes::CameraSpec& spec : scenes::randomCameras(seed, *scene, kCamerasPerScene)) {
    SCOPED_TRACE("seed " + std::to_string(seed) + " camera " + spec.what);
    auto camera = scenes::toCamera(spec);
    ASSERT_TRUE(camera.ok()) << camera.error().message;
    OracleOptions options;
    options.lattice = 1;
    options.max_samples = 20'000;
    options.rays_per_object = 24;
    options.seed = seed;
    auto truth = oracle.value()->look(camera.value(), options);
    ASSERT_TRUE(truth.ok()) << truth.error().message;
    ++tally.looks;
    tally.visible += truth.value().visible.size();
    for (PreparedMethod& method : methods) {
      const Answer answer = method.culler->cull(camera.value(), {}, method.view);
      expectWellFormed(answer, *scene);
      const auto lost = missing(truth.value().visible, answer.visible);
      tally.missed += lost.size();
      EXPECT_TRUE(lost.empty()) << method.name << " lacks object " << lost.front();
      if (method.name == "frustum") tally.frustum += answer.visible.size();
      if (method.name == "raster") tally.raster += answer.visible.size();
    }
  }
}

TEST(RandomScenes, NoMethodLacksAnObjectThatTheOracleSees) {
  Tally tally;
  for (std::uint64_t seed = 1; seed <= kScenes && !HasFatalFailure(); ++seed)
    judgeScene(seed, tally);
  RecordProperty("visible", static_cast<int>(tally.visible));
  std::printf("%zu looks: %zu visible, frustum answered %zu, raster answered %zu, missed %zu\n",
              tally.looks, tally.visible, tally.frustum, tally.raster, tally.missed);
  EXPECT_EQ(tally.looks, kScenes * kCamerasPerScene);
  EXPECT_GT(tally.visible, 10 * tally.looks);  // the scenes are not empty
  EXPECT_LT(tally.raster, tally.frustum);      // and something is hidden in them
}

/// Each method with each of its settings at either end: what a part is left out of must be right
/// too, and hierarchies are deep only at settings that these small scenes do not have by default.
std::vector<PreparedMethod> prepareExtremes(ConfiguredMethods& methods, const SnapshotPtr& scene) {
  std::vector<PreparedMethod> out;
  for (const Method* method : allMethods()) {
    for (const Setting& setting : method->settings()) {
      for (const double value : {setting.least, setting.most}) {
        if (value == setting.standard) continue;
        const std::string name = std::string(method->info().name) + ":" +
                                 std::string(setting.name) + "=" + valueText(setting, value);
        auto culler = methods.find(name).value()->prepare(scene);
        EXPECT_TRUE(culler.ok()) << name;
        if (culler.ok()) out.push_back({name, std::move(culler).value(), ViewState{}});
      }
    }
  }
  return out;
}

TEST(RandomScenes, NoMethodLacksAnObjectAtTheEndsOfItsSettings) {
  ConfiguredMethods configured(allMethods());
  for (std::uint64_t seed = 1001; seed <= 1000 + scenes::rounds(24); ++seed) {
    scenes::RandomSceneOptions larger;
    larger.objects = 300;
    const SnapshotPtr scene = scenes::randomScene(seed, larger);
    auto oracle = Oracle::build(scene);
    ASSERT_TRUE(oracle.ok()) << oracle.error().message;
    std::vector<PreparedMethod> methods = prepareExtremes(configured, scene);
    EXPECT_GT(methods.size(), 50U);
    std::size_t looks = 0;
    for (const scenes::CameraSpec& spec : scenes::randomCameras(seed, *scene, kCamerasPerScene)) {
      const Camera camera = scenes::toCamera(spec).value();
      OracleOptions options;
      options.max_samples = 20'000;
      const auto truth = oracle.value()->look(camera, options);
      ASSERT_TRUE(truth.ok()) << truth.error().message;
      for (PreparedMethod& method : methods) {
        const Answer answer = method.culler->cull(camera, {}, method.view);
        expectWellFormed(answer, *scene);
        const auto lost = missing(truth.value().visible, answer.visible);
        EXPECT_TRUE(lost.empty()) << method.name << ", seed " << seed << ", camera " << spec.what
                                  << " lacks object " << lost.front();
        ++looks;
      }
    }
    EXPECT_EQ(looks, methods.size() * kCamerasPerScene);
  }
}

TEST(RandomScenes, EveryTargetGivesTheSameAnswer) {
  for (std::uint64_t seed = 1; seed <= scenes::rounds(60); ++seed) {
    const SnapshotPtr scene = scenes::randomScene(seed);
    std::vector<PreparedMethod> methods = prepareAll(scene);
    for (const scenes::CameraSpec& spec : scenes::randomCameras(seed, *scene, kCamerasPerScene)) {
      const Camera camera = scenes::toCamera(spec).value();
      for (PreparedMethod& method : methods) {
        std::optional<std::vector<ObjectId>> first;
        for (const std::string& target : simdTargets()) {
          ASSERT_TRUE(forceSimdTarget(target).ok());
          ViewState fresh;
          std::vector<ObjectId> visible = method.culler->cull(camera, {}, fresh).visible;
          if (!first) first = visible;
          ASSERT_EQ(visible, *first) << method.name << " " << target << " seed " << seed;
        }
      }
    }
  }
  ASSERT_TRUE(forceSimdTarget("auto").ok());
}

TEST(RandomScenes, DroppingTheViewStateChangesNothing) {
  for (std::uint64_t seed = 1; seed <= scenes::rounds(60); ++seed) {
    const SnapshotPtr scene = scenes::randomScene(seed);
    for (PreparedMethod& method : prepareAll(scene)) {
      if (method.name == "auto") continue;  // the one method that learns from what a view has seen
      for (const scenes::CameraSpec& spec : scenes::randomCameras(seed, *scene, 6)) {
        const Camera camera = scenes::toCamera(spec).value();
        ViewState fresh;
        EXPECT_EQ(method.culler->cull(camera, {}, method.view).visible,
                  method.culler->cull(camera, {}, fresh).visible);
      }
    }
  }
}

}  // namespace
}  // namespace culld
