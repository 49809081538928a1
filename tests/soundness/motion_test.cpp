// A camera that may be anywhere within a motion bound: no method may lack what any pose within it
// sees, and an answer made for one pose only must be caught.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "tests/scenes/city.h"
#include "tests/scenes/random.h"
#include "tests/scenes/random_scene.h"
#include "tests/soundness/judge.h"

namespace culld {
namespace {

struct Tally {
  std::size_t looks = 0, visible = 0, answered = 0;
  std::size_t missed = 0;     ///< by answers to the bound
  std::size_t unwidened = 0;  ///< by answers to the camera's own pose
};

Answer cullOf(const PreparedMethod& method, const Camera& camera) {
  ViewState view;
  return method.culler->cull(camera, {}, view);
}

void judgeMotion(const SnapshotPtr& scene, const Oracle& oracle,
                 const std::vector<PreparedMethod>& methods, const Camera& camera,
                 const OracleOptions& options, Tally& tally) {
  const auto truth = oracle.look(camera, options);
  ASSERT_TRUE(truth.ok()) << truth.error().message;
  ++tally.looks;
  tally.visible += truth.value().visible.size();
  Camera still = camera;
  still.motion = {};
  for (const PreparedMethod& method : methods) {
    const Answer answer = cullOf(method, camera);
    expectWellFormed(answer, *scene);
    tally.answered += answer.visible.size();
    const auto lost = missing(truth.value().visible, answer.visible);
    tally.missed += lost.size();
    EXPECT_TRUE(lost.empty()) << method.name << " lacks object " << lost.front();
    tally.unwidened += missing(truth.value().visible, cullOf(method, still).visible).size();
  }
}

double usualSize(const SceneSnapshot& scene) {
  std::vector<double> sizes{1.0};
  for (ObjectId id = 0; id < scene.objectCount(); ++id) {
    const Box& box = scene.instance(id).bounds_world;
    if (!box.empty()) sizes.push_back(glm::length(box.max - box.min));
  }
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2),
                   sizes.end());
  return sizes[sizes.size() / 2];
}

TEST(MotionBounds, NoMethodLacksWhatAPoseWithinTheBoundSees) {
  Tally tally;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const SnapshotPtr scene = scenes::randomScene(seed);
    const auto oracle = Oracle::build(scene);
    ASSERT_TRUE(oracle.ok());
    const std::vector<PreparedMethod> methods = prepareAll(scene);
    scenes::Random random(seed);
    const double size = usualSize(*scene);
    for (const scenes::CameraSpec& spec : scenes::randomCameras(seed, *scene, 2)) {
      SCOPED_TRACE("seed " + std::to_string(seed) + " camera " + spec.what);
      Camera camera = scenes::toCamera(spec).value();
      const double reach = std::pow(10.0, random.uniform(-2.0, 0.5));
      if (!random.chance(0.2)) camera.motion.radius_m = size * reach;
      if (!random.chance(0.3)) camera.motion.angle_rad = std::pow(10.0, random.uniform(-3.0, 0.3));
      judgeMotion(scene, *oracle.value(), methods, camera,
                  {.lattice = 1, .max_samples = 3'000, .seed = seed}, tally);
    }
  }
  std::printf("%zu looks: %zu visible, answered %zu, missed %zu, by answers to one pose %zu\n",
              tally.looks, tally.visible, tally.answered, tally.missed, tally.unwidened);
  EXPECT_EQ(tally.missed, 0U);
  EXPECT_GT(tally.unwidened, tally.looks);
}

TEST(MotionBounds, NoMethodLacksWhatAWalkerInTheCitySees) {
  const scenes::City city = scenes::generateCity({.seed = 3, .objects = 4'000, .frames = 12});
  const SnapshotPtr scene = scenes::toSnapshot(city.model);
  const auto oracle = Oracle::build(scene);
  ASSERT_TRUE(oracle.ok());
  const std::vector<PreparedMethod> methods = prepareAll(scene);
  Tally tally;
  for (std::size_t i = 0; i < city.cameras.size(); i += 2) {
    SCOPED_TRACE("camera " + std::to_string(i));
    Camera camera = scenes::toCamera(city.cameras[i]).value();
    camera.motion = {0.5, 0.05};
    judgeMotion(scene, *oracle.value(), methods, camera, {.lattice = 1, .max_samples = 20'000},
                tally);
  }
  EXPECT_EQ(tally.missed, 0U);
  EXPECT_GT(tally.unwidened, 10U);
}

}  // namespace
}  // namespace culld
