// A camera that may be anywhere within a motion bound: no method may lack what any pose within it
// sees, and an answer made for one pose only must be caught.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <glm/geometric.hpp>

#include "tests/scenes/city.h"
#include "tests/scenes/landscapes.h"
#include "tests/scenes/random.h"
#include "tests/scenes/random_scene.h"
#include "tests/scenes/rounds.h"
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
  for (std::uint64_t seed = 1; seed <= scenes::rounds(40); ++seed) {
    const SnapshotPtr scene = scenes::randomScene(seed);
    const auto oracle = Oracle::build(scene);
    ASSERT_TRUE(oracle.ok());
    const std::vector<PreparedMethod> methods = prepareAll(scene, kFrustumSettings);
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
  const std::vector<PreparedMethod> methods = prepareAll(scene, kFrustumSettings);
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

struct Motions {
  std::size_t looks = 0, in_frustum = 0, not_nested = 0;
  std::vector<std::size_t> answered;  ///< by radius
};

constexpr double kRadii[] = {0.05, 0.15, 0.3, 0.6, 1.2};

/// `raster` at growing radii against what poses within each of them see.
void judgeRadii(const SnapshotPtr& scene, const std::vector<scenes::CameraSpec>& cameras,
                std::size_t step, Motions& all) {
  const auto oracle = Oracle::build(scene);
  const auto raster = findMethod("raster")->prepare(scene);
  const auto frustum = findMethod("frustum")->prepare(scene);
  ASSERT_TRUE(oracle.ok() && raster.ok() && frustum.ok());
  all.answered.resize(std::size(kRadii) + 1);
  ViewState view;
  for (std::size_t c = 0; c < cameras.size(); c += step) {
    Camera camera = scenes::toCamera(cameras[c]).value();
    std::vector<ObjectId> before = raster.value()->cull(camera, {}, view).visible;
    all.answered[0] += before.size();
    ++all.looks;
    for (std::size_t i = 0; i < std::size(kRadii); ++i) {
      SCOPED_TRACE("camera " + std::to_string(c) + " radius " + std::to_string(kRadii[i]));
      camera.motion = {kRadii[i], (c / step) % 2 == 0 ? 0.0 : 0.1};
      const auto truth = oracle.value()->look(
          camera, {.lattice = 1, .max_samples = 8'000, .rays_per_object = 4, .seed = c + i});
      ASSERT_TRUE(truth.ok()) << truth.error().message;
      const Answer answer = raster.value()->cull(camera, {}, view);
      expectWellFormed(answer, *scene);
      EXPECT_EQ(answer.note, "");
      const auto lost = missing(truth.value().visible, answer.visible);
      EXPECT_TRUE(lost.empty()) << "raster lacks object " << lost.front();
      all.answered[i + 1] += answer.visible.size();
      all.not_nested += missing(before, answer.visible).size();
      before = answer.visible;
    }
    all.in_frustum += frustum.value()->cull(camera, {}, view).visible.size();
  }
}

void expectUseful(const char* name, const Motions& all) {
  std::printf("%s: %zu looks, answered", name, all.looks);
  for (const std::size_t n : all.answered) std::printf(" %zu", n);
  std::printf(", in the frustum at last %zu, lost again at a larger radius %zu\n", all.in_frustum,
              all.not_nested);
  for (std::size_t i = 1; i < all.answered.size(); ++i) {
    EXPECT_LE(all.answered[i - 1], all.answered[i]);
  }
  EXPECT_LT(2 * all.answered[3], all.in_frustum) << "occlusion in motion leaves little out";
  // The grid, what is drawn and who is asked hang on the radius; the sums must not.
  EXPECT_LT(10 * all.not_nested, all.answered[5]);
}

TEST(MotionBounds, RasterLacksNothingAtGrowingRadiiInTheCity) {
  const scenes::City city = scenes::generateCity({.seed = 5, .objects = 6'000, .frames = 20});
  Motions all;
  judgeRadii(scenes::toSnapshot(city.model), city.cameras, 3, all);
  expectUseful("city", all);
}

TEST(MotionBounds, RasterLacksNothingAtGrowingRadiiInRooms) {
  const scenes::Landscape rooms = scenes::closedRooms({.objects = 4'000, .frames = 12});
  Motions all;
  judgeRadii(scenes::toSnapshot(rooms.model), rooms.cameras, 2, all);
  expectUseful("rooms", all);
}

TEST(MotionBounds, AHugeRadiusGetsAboutTheFrustumsAnswer) {
  const scenes::City city = scenes::generateCity({.seed = 5, .objects = 3'000, .frames = 10});
  const SnapshotPtr scene = scenes::toSnapshot(city.model);
  const auto raster = findMethod("raster")->prepare(scene);
  const auto frustum = findMethod("frustum")->prepare(scene);
  ASSERT_TRUE(raster.ok() && frustum.ok());
  for (std::size_t c = 0; c < city.cameras.size(); c += 3) {
    Camera camera = scenes::toCamera(city.cameras[c]).value();
    camera.motion.radius_m = 1e4;
    ViewState one, other;
    EXPECT_EQ(raster.value()->cull(camera, {}, one).visible,
              frustum.value()->cull(camera, {}, other).visible);
  }
}

}  // namespace
}  // namespace culld
