// Ray by ray against a tracer of another kind: what meets the eye must be the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "culling/oracle/ray_scene.h"
#include "tests/scenes/random_scene.h"
#include "tests/unit/oracle/brute_tracer.h"
#include "tests/unit/oracle/small_scenes.h"

namespace culld {
namespace {

using oracle_test::BruteHit;
using oracle_test::BruteRay;
using oracle_test::Rows;
using oracle_test::Scene;

double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Any rotation, mirror and shear; now and then nearly or exactly flat.
Rows randomRows(std::mt19937_64& random, const glm::dvec3& around, double spread) {
  Rows rows{};
  const double size = std::exp(uniform(random, -1.0, 1.5));
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) rows[4 * i + j] = size * uniform(random, -1.0, 1.0);
    rows[4 * i + 3] = around[static_cast<int>(i)] + spread * uniform(random, -1.0, 1.0);
  }
  const auto flat = random() % 8;
  for (std::size_t i = 0; i < 3 && flat < 2; ++i) rows[4 * i + 2] *= flat == 0 ? 0.0 : 1e-8;
  return rows;
}

RawSurface randomSurface(std::mt19937_64& random) {
  const bool blocks = random() % 4 != 0, double_sided = random() % 2 == 0;
  if (random() % 3 == 0) return oracle_test::wall(blocks, double_sided);
  RawSurface surface = oracle_test::cube();
  surface.blocks = blocks;
  surface.double_sided = double_sided;
  if (random() % 2 == 0) {  // crumpled
    for (glm::vec3& p : surface.positions) p *= static_cast<float>(uniform(random, 0.2, 2.0));
  }
  return surface;
}

SnapshotPtr randomScene(std::uint64_t seed, const glm::dvec3& around) {
  std::mt19937_64 random(seed);
  Scene scene;
  for (int i = 0; i < 60; ++i) scene.add(randomSurface(random), randomRows(random, around, 6.0));
  return scene.finish();
}

Camera randomCamera(std::uint64_t seed, const glm::dvec3& around) {
  std::mt19937_64 random(seed);
  LookAt look;
  look.eye = around + glm::dvec3(uniform(random, -8, 8), uniform(random, -8, 8), 8);
  look.target = around + glm::dvec3(uniform(random, -2, 2), uniform(random, -2, 2), 0);
  look.yfov_rad = uniform(random, 0.05, 1.5);
  if (seed % 2 == 0) look.zfar_m = 20.0;
  return cameraFromLookAt(look, {64, 36}).value();
}

BruteRay bruteRay(const oracle::Ray& ray) {
  const auto vec = [](const glm::dvec3& v) { return oracle_test::Vec{v.x, v.y, v.z}; };
  return {vec(ray.origin), vec(ray.direction), ray.t_min, ray.t_max};
}

struct Compared {
  std::size_t agreed = 0;  ///< surfaces that both saw
  std::size_t missed = 0;  ///< seen for certain, and not by the oracle
  std::size_t wrong = 0;   ///< seen by the oracle, and hidden for certain
};

/// Only what is certain counts: hits well within triangles that are not edge-on.
bool certain(const BruteHit& hit) { return hit.inside > 1e-5L && hit.facing > 1e-5L; }

void compare(const std::vector<BruteHit>& truth, const oracle::RayView& view,
             const oracle::Hits& hits, Compared& result) {
  long double certain_block = INFINITY, possible_block = INFINITY;
  for (const BruteHit& hit : truth) {
    if (!hit.blocks) continue;
    possible_block = std::min(possible_block, hit.t);
    if (certain(hit)) certain_block = std::min(certain_block, hit.t);
  }
  for (const oracle::Hit& hit : hits.found) {
    if (hit.tie) continue;
    const ObjectId object = view.objects()[hit.placed].object;
    const bool met = std::any_of(truth.begin(), truth.end(), [&](const BruteHit& t) {
      return t.object == object && std::abs(t.t - hit.t) <= 1e-6L * t.t;
    });
    // A hit on the very rim of a triangle may be on either side of it.
    const bool hidden = hit.t > certain_block * (1 + 1e-8L);
    (met && !hidden ? result.agreed : result.wrong) += 1;
  }
  for (const BruteHit& hit : truth) {
    if (!certain(hit) || !(hit.t < possible_block * (1 - 1e-8L) || hit.t == possible_block))
      continue;
    const bool found = std::any_of(hits.found.begin(), hits.found.end(), [&](const auto& h) {
      return view.objects()[h.placed].object == hit.object && !h.tie &&
             std::abs(h.t - hit.t) <= 1e-6L * hit.t;
    });
    if (!found) ++result.missed;
  }
}

Compared compareScene(const SnapshotPtr& snapshot, const Camera& camera, std::uint64_t seed) {
  const auto scene = oracle::RayScene::build(snapshot);
  const auto view = oracle::RayView::build(*scene.value(), camera);
  std::mt19937_64 random(seed);
  Compared result;
  oracle::Hits hits;
  for (int i = 0; i < 200; ++i) {
    const auto ray = view.value()->rays().through(uniform(random, -1, 1), uniform(random, -1, 1));
    if (!ray) continue;
    view.value()->trace(*ray, hits);
    compare(bruteHits(*snapshot, camera, bruteRay(*ray)), *view.value(), hits, result);
  }
  return result;
}

class TraceTest : public testing::TestWithParam<double> {};

TEST_P(TraceTest, AgreesWithATracerOfAnotherKindOnRandomScenes) {
  const glm::dvec3 around(GetParam(), -GetParam(), 0.5 * GetParam());
  std::size_t agreed = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const Compared result =
        compareScene(randomScene(seed, around), randomCamera(seed, around), seed);
    EXPECT_EQ(result.missed, 0U) << "seed " << seed;
    EXPECT_EQ(result.wrong, 0U) << "seed " << seed;
    agreed += result.agreed;
  }
  EXPECT_GT(agreed, 3000U);
}

TEST(TraceOnGeneratedScenes, AgreesWithATracerOfAnotherKind) {
  std::size_t agreed = 0;
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    const SnapshotPtr scene = scenes::randomScene(seed, {.objects = 30});
    for (const scenes::CameraSpec& spec : scenes::randomCameras(seed, *scene, 4)) {
      const auto camera = scenes::toCamera(spec);
      ASSERT_TRUE(camera.ok()) << spec.what;
      const Compared result = compareScene(scene, camera.value(), seed);
      EXPECT_EQ(result.missed, 0U) << "seed " << seed << " " << spec.what;
      EXPECT_EQ(result.wrong, 0U) << "seed " << seed << " " << spec.what;
      agreed += result.agreed;
    }
  }
  EXPECT_GT(agreed, 3000U);
}

INSTANTIATE_TEST_SUITE_P(Offsets, TraceTest, testing::Values(0.0, 1e3, 6.4e6));

}  // namespace
}  // namespace culld
