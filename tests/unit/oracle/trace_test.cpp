// Ray by ray against a tracer of another kind: what meets the eye must be the same.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat4x4.hpp>
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

/// Where a scene is, and how large its objects are.
struct Place {
  double offset_m;
  double size_m;
};

/// Any rotation, mirror and shear; now and then flat: exactly, nearly, or up to rounding.
Rows randomRows(std::mt19937_64& random, const glm::dvec3& around, double size_m) {
  Rows rows{};
  const double size = size_m * std::exp(uniform(random, -1.0, 1.5));
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) rows[4 * i + j] = size * uniform(random, -1.0, 1.0);
    rows[4 * i + 3] = around[static_cast<int>(i)] + 6.0 * size_m * uniform(random, -1.0, 1.0);
  }
  const auto flat = random() % 16;
  for (std::size_t i = 0; i < 3; ++i) {
    double& z = rows[4 * i + 2];
    if (flat < 2) z *= flat == 0 ? 0.0 : 1e-8;
    if (flat == 2 || flat == 3) {
      z = 0.7 * rows[4 * i] - 0.3 * rows[4 * i + 1] + (flat == 2 ? 0.0 : 1e-9 * z);
    }
  }
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

/// Every third mesh has surfaces of several kinds.
SnapshotPtr randomScene(std::uint64_t seed, const glm::dvec3& around, double size_m) {
  std::mt19937_64 random(seed);
  Scene scene;
  for (int i = 0; i < 60; ++i) {
    std::vector<RawSurface> surfaces{randomSurface(random)};
    if (i % 3 == 0) surfaces.push_back(randomSurface(random));
    if (i % 6 == 0) surfaces.push_back(randomSurface(random));
    scene.add(surfaces, randomRows(random, around, size_m));
  }
  return scene.finish();
}

Camera randomCamera(std::uint64_t seed, const glm::dvec3& around, double size_m) {
  std::mt19937_64 random(seed);
  const auto aside = [&](double reach) { return size_m * uniform(random, -reach, reach); };
  LookAt look;
  look.eye = around;
  look.eye += glm::dvec3(aside(8), 0, 8 * size_m);
  look.eye.y += aside(8);
  look.target = around + glm::dvec3(aside(2), 0, 0);
  look.target.y += aside(2);
  look.yfov_rad = uniform(random, 0.05, 1.5);
  look.znear_m = 0.1 * size_m;
  if (seed % 2 == 0) look.zfar_m = 20.0 * size_m;
  return cameraFromLookAt(look, {64, 36}).value();
}

/// The same view through matrices: orthographic, off-centre, mirrored.
Camera matrixCamera(std::uint64_t seed, const glm::dvec3& around, double size_m) {
  std::mt19937_64 random(seed);
  const double turn = uniform(random, -0.5, 0.5), c = std::cos(turn), s = std::sin(turn);
  const glm::dvec3 right(c, 0, s), back(-s, 0, c);
  const glm::dvec3 eye = around + 8.0 * size_m * back;
  glm::dmat4 view(1.0);
  const double mirror = random() % 3 == 0 ? -1.0 : 1.0;
  for (int i = 0; i < 3; ++i) view[i] = {mirror * right[i], i == 1 ? 1.0 : 0.0, back[i], 0.0};
  view[3] = {-mirror * glm::dot(right, eye), -eye.y, -glm::dot(back, eye), 1.0};
  glm::dmat4 projection(0.0);
  const double near = 0.1 * size_m, far = 20.0 * size_m;
  if (seed % 2 == 0) {
    projection[0][0] = projection[1][1] = 1.0 / (uniform(random, 2.0, 8.0) * size_m);
    projection[2][2] = -2.0 / (far - near);
    projection[3] = {uniform(random, -0.5, 0.5), 0.2, -(far + near) / (far - near), 1.0};
  } else {
    projection[0][0] = projection[1][1] = uniform(random, 0.5, 4.0);
    projection[2] = {uniform(random, -1.0, 1.0), 0.3, -(far + near) / (far - near), -1.0};
    projection[3][2] = -2.0 * far * near / (far - near);
  }
  return cameraFromMatrices(view, projection, {64, 36}).value();
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
bool certain(const BruteHit& hit) {
  return hit.inside > 1e-5L && hit.facing > 1e-5L && hit.side_known;
}

/// How far along the ray a surface moves if its points move by `rounding` across it.
long double slackOf(const BruteHit& hit, long double rounding) {
  return 1e-8L * std::abs(hit.t) + rounding / hit.facing;
}

const BruteHit* sameSurface(const std::vector<BruteHit>& truth, ObjectId object, double t,
                            long double rounding) {
  for (const BruteHit& hit : truth) {
    const long double near = 1e-6L * std::abs(hit.t) + rounding / hit.facing;
    if (hit.object == object && std::abs(hit.t - t) <= near) return &hit;
  }
  return nullptr;
}

/// `rounding`: of positions relative to the eye, in units of t.
void compare(const std::vector<BruteHit>& truth, const oracle::RayView& view,
             const oracle::Hits& hits, long double rounding, Compared& result) {
  long double certain_block = INFINITY, possible_block = INFINITY;
  for (const BruteHit& hit : truth) {
    if (!hit.blocks) continue;
    possible_block = std::min(possible_block, hit.t - slackOf(hit, rounding));
    if (certain(hit)) certain_block = std::min(certain_block, hit.t + slackOf(hit, rounding));
  }
  for (const oracle::Hit& hit : hits.found) {
    if (hit.tie) continue;
    const ObjectId object = view.objects()[hit.placed].object;
    const BruteHit* met = sameSurface(truth, object, hit.t, rounding);
    // A hit on the very rim of a triangle may be on either side of it.
    const bool hidden = met == nullptr || hit.t > certain_block + slackOf(*met, rounding);
    (hidden ? result.wrong : result.agreed) += 1;
  }
  for (const BruteHit& hit : truth) {
    const bool front = hit.t < possible_block || hit.t - slackOf(hit, rounding) == possible_block;
    if (!certain(hit) || !front) continue;
    const bool found = std::any_of(hits.found.begin(), hits.found.end(), [&](const auto& h) {
      return view.objects()[h.placed].object == hit.object && !h.tie &&
             std::abs(h.t - hit.t) <= 1e-6L * std::abs(hit.t) + slackOf(hit, rounding);
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
    const double rounding =
        0x1p-49 * glm::length(camera.origin_world) / glm::length(ray->direction);
    compare(bruteHits(*snapshot, camera, bruteRay(*ray)), *view.value(), hits, rounding, result);
  }
  return result;
}

class TraceTest : public testing::TestWithParam<Place> {
 protected:
  template <typename MakeCamera>
  void compareMany(MakeCamera make_camera) {
    const Place& place = GetParam();
    const glm::dvec3 around(place.offset_m, -place.offset_m, 0.5 * place.offset_m);
    std::size_t agreed = 0;
    for (std::uint64_t seed = 1; seed <= 24; ++seed) {
      const Compared result = compareScene(randomScene(seed, around, place.size_m),
                                           make_camera(seed, around, place.size_m), seed);
      EXPECT_EQ(result.missed, 0U) << "seed " << seed;
      EXPECT_EQ(result.wrong, 0U) << "seed " << seed;
      agreed += result.agreed;
    }
    EXPECT_GT(agreed, 2000U);
  }
};

TEST_P(TraceTest, AgreesWithATracerOfAnotherKindOnRandomScenes) { compareMany(randomCamera); }

TEST_P(TraceTest, AgreesThroughOrthographicOffCentreAndMirroredCameras) {
  compareMany(matrixCamera);
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

/// What a ray through a point of the plane z = -5 sees of a wall there and a larger one behind it.
std::vector<ObjectId> seenThrough(const glm::dvec3& point) {
  Scene builder;
  builder.add(oracle_test::wall(), oracle_test::at(0, 0, -5));
  builder.add(oracle_test::wall(), oracle_test::at(0, 0, -10, 9, 9));
  const auto scene = oracle::RayScene::build(builder.finish());
  const auto view = oracle::RayView::build(*scene.value(), oracle_test::cameraAt({0, 0, 0}));
  oracle::Hits hits;
  view.value()->trace(view.value()->rays().at(point)->ray, hits);
  std::vector<ObjectId> seen;
  for (const oracle::Hit& hit : hits.found) {
    if (!hit.tie) seen.push_back(view.value()->objects()[hit.placed].object);
  }
  return seen;
}

TEST(TraceAtARim, TheRimThatRoundingAddsBlocksAndIsNotSeen) {
  using Ids = std::vector<ObjectId>;
  EXPECT_EQ(seenThrough({0.5 - 5e-8, 0.1, -5}), Ids{0});
  EXPECT_EQ(seenThrough({0.5 + 5e-8, 0.1, -5}), Ids{});
  EXPECT_EQ(seenThrough({0.5 + 5e-7, 0.1, -5}), Ids{1});
}

INSTANTIATE_TEST_SUITE_P(Places, TraceTest,
                         testing::Values(Place{0.0, 1.0}, Place{1e3, 1.0}, Place{6.4e6, 1.0},
                                         Place{1e7, 0.01}, Place{0.0, 1e-6}, Place{1e7, 1e5}));

}  // namespace
}  // namespace culld
