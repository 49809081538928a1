// Answers that may lose pixels: what a method proves to have lost at most is no less than what the
// oracle sees missing, and no more than was accepted; what it estimates is seldom less.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "tests/scenes/city.h"
#include "tests/scenes/random_scene.h"
#include "tests/scenes/rounds.h"
#include "tests/soundness/judge.h"

namespace culld {
namespace {

struct Tally {
  std::string method;
  std::size_t answers = 0, lossy = 0, exceeded = 0;
  double said_px = 0.0, lost_px = 0.0;
};

/// Every method, and those that can be told to lose more.
std::vector<PreparedMethod> prepareLossy(const SnapshotPtr& scene) {
  std::vector<PreparedMethod> methods = prepareAll(scene);
  for (const char* name : {"occlusion-map:opacity=0.25"}) {
    ConfiguredMethods configured(allMethods());
    const auto method = configured.find(name);
    EXPECT_TRUE(method.ok());
    methods.push_back({name, method.value()->prepare(scene, steadyClock()).value(), ViewState{}});
  }
  return methods;
}

double lostPx(const OracleAnswer& truth, const Answer& answer) {
  double lost = 0.0;
  for (std::size_t i = 0; i < truth.visible.size(); ++i) {
    const bool answered =
        std::binary_search(answer.visible.begin(), answer.visible.end(), truth.visible[i]);
    if (!answered) lost += static_cast<double>(truth.pixels[i]);
  }
  return lost;
}

void judge(const SnapshotPtr& scene, const std::vector<scenes::CameraSpec>& cameras,
           float accepted_px, std::vector<Tally>& tallies) {
  const auto oracle = Oracle::build(scene);
  ASSERT_TRUE(oracle.ok());
  std::vector<PreparedMethod> methods = prepareLossy(scene);
  tallies.resize(methods.size());
  Demand demand;
  demand.guarantee = Guarantee::kApproximate;
  demand.accepted_missed_px = accepted_px;
  for (const scenes::CameraSpec& spec : cameras) {
    const Camera camera = scenes::toCamera(spec).value();
    OracleOptions options;
    options.lattice = 2;
    options.max_samples = 400'000;
    const auto truth = oracle.value()->look(camera, options);
    ASSERT_TRUE(truth.ok());
    const double samples = std::min(4.0 * camera.width_px * camera.height_px, 4e5);
    const double px_per_sample = static_cast<double>(camera.width_px) * camera.height_px / samples;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      const Answer answer = methods[m].culler->cull(camera, demand, methods[m].view);
      const double lost = lostPx(truth.value(), answer);
      const auto said = static_cast<double>(answer.missed_px);
      Tally& tally = tallies[m];
      tally.method = methods[m].name;
      ++tally.answers;
      tally.said_px += said;
      tally.lost_px += lost;
      if (said > 0.0) ++tally.lossy;
      // What is lost was hit by samples at random: four standard deviations of their number.
      const double doubt = 4.0 * std::sqrt(std::max(said, px_per_sample) * px_per_sample);
      if (lost > said + doubt) ++tally.exceeded;
      if (answer.proven) {
        EXPECT_LE(lost, said + doubt) << methods[m].name << " camera " << spec.what;
        EXPECT_LE(answer.missed_px, accepted_px) << methods[m].name;
      }
    }
  }
}

/// An estimate may be too low, but not often.
void expectCalibrated(const char* where, const std::vector<Tally>& tallies) {
  for (const Tally& t : tallies) {
    std::printf("%s %s: %zu of %zu answers lossy, said %.0f px, lost %.0f px, exceeded %zu\n",
                where, t.method.c_str(), t.lossy, t.answers, t.said_px, t.lost_px, t.exceeded);
    EXPECT_LE(4 * t.exceeded, t.answers) << t.method;
  }
}

TEST(ApproximateAnswers, LoseNoMoreThanTheySayInTheCity) {
  const scenes::City city = scenes::generateCity({.seed = 3, .objects = 4'000, .frames = 12});
  const SnapshotPtr scene = scenes::toSnapshot(city.model);
  for (const float accepted_px : {20.0F, 2000.0F}) {
    std::vector<Tally> tallies;
    judge(scene, city.cameras, accepted_px, tallies);
    expectCalibrated("city", tallies);
    for (const Tally& t : tallies) {
      if (accepted_px < 2000.0F || (t.method != "layers" && t.method != "occlusion-map")) continue;
      EXPECT_GT(t.lossy, 0U) << t.method << " was never judged by what it loses";
    }
  }
}

TEST(ApproximateAnswers, LoseNoMoreThanTheySayInScenesMadeToBreakThem) {
  std::vector<Tally> tallies;
  for (std::uint64_t seed = 1; seed <= scenes::rounds(30); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const SnapshotPtr scene = scenes::randomScene(seed);
    judge(scene, scenes::randomCameras(seed, *scene, 2), 5000.0F, tallies);
  }
  expectCalibrated("random", tallies);
}

}  // namespace
}  // namespace culld
