// Pairs that are called hidden, against rays in long double that try to prove the contrary.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "culling/core/camera.h"
#include "culling/pairs/pairs.h"
#include "tests/scenes/random.h"
#include "tests/scenes/random_scene.h"
#include "tests/scenes/rounds.h"
#include "tests/scenes/shapes.h"
#include "tests/unit/oracle/brute_tracer.h"

namespace culld {
namespace {

using scenes::Random;

Box worldOf(const SceneSnapshot& scene) {
  Box box;
  for (std::size_t i = 0; i < scene.objectCount(); ++i) {
    const Box& bounds = scene.instance(static_cast<ObjectId>(i)).bounds_world;
    if (bounds.finite()) box.grow(bounds);
  }
  return box;
}

glm::dvec3 pointIn(const Box& box, Random& random) {
  glm::dvec3 p;
  for (int axis = 0; axis < 3; ++axis) p[axis] = random.uniform(box.min[axis], box.max[axis]);
  return p;
}

/// Around some object more often than anywhere in the world: most of the world is empty.
Place randomPlace(const SceneSnapshot& scene, const Box& world, Random& random) {
  const auto object =
      static_cast<ObjectId>(random.below(static_cast<std::uint32_t>(scene.objectCount())));
  Box around = scene.instance(object).bounds_world;
  if (!around.finite() || around.empty() || random.chance(0.3)) around = world;
  const glm::dvec3 size = around.max - around.min;
  around = {around.min - size, around.max + size};
  const glm::dvec3 centre = pointIn(around, random);
  Place place{{centre, centre}, 0.0};
  if (random.chance(0.4)) {
    const double half = 0.05 * random.unit() * std::max({size.x, size.y, size.z});
    place.box = {centre - half, centre + half};
  }
  if (random.chance(0.3)) place.radius_m = 0.05 * random.unit() * size.y;
  return place;
}

glm::dvec3 pointOf(const Place& place, Random& random) {
  glm::dvec3 p = place.box.min;
  for (int axis = 0; axis < 3; ++axis) {  // corners count most
    const double share = random.chance(0.6) ? (random.chance(0.5) ? 0.0 : 1.0) : random.unit();
    p[axis] += share * (place.box.max[axis] - place.box.min[axis]);
    p[axis] = std::clamp(p[axis], place.box.min[axis], place.box.max[axis]);
  }
  const glm::dvec3 step(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  return p + step * (place.radius_m * 0.57);  // within the ball
}

bool blocked(const SceneSnapshot& scene, const glm::dvec3& from, const glm::dvec3& to) {
  LookAt look;
  look.eye = from;
  look.target = from + glm::dvec3(0, 0, -1e7);  // not lost in rounding
  const Camera camera = cameraFromLookAt(look, {}).value();
  oracle_test::BruteRay ray;
  ray.direction = {static_cast<long double>(to.x) - from.x, static_cast<long double>(to.y) - from.y,
                   static_cast<long double>(to.z) - from.z};
  ray.t_max = 1;
  const auto hits = oracle_test::bruteHits(scene, camera, ray);
  return std::any_of(hits.begin(), hits.end(), [](const auto& hit) { return hit.blocks; });
}

TEST(PairsAttack, NoSegmentIsFreeBetweenPlacesThatAreHidden) {
  std::uint64_t hidden = 0, pairs = 0;
  for (std::uint64_t seed = 1; seed <= scenes::rounds(60); ++seed) {
    const SnapshotPtr scene = scenes::randomScene(seed);
    const Box world = worldOf(*scene);
    const PairsCuller culler(*scene);
    Random random(seed * 7919);
    std::vector<Place> viewers, targets;
    for (int i = 0; i < 12; ++i) viewers.push_back(randomPlace(*scene, world, random));
    for (int i = 0; i < 40; ++i) targets.push_back(randomPlace(*scene, world, random));
    const auto answer = culler.cull(viewers, targets).value();
    for (std::size_t pair = 0; pair < 480; ++pair) {
      ++pairs;
      if ((answer.may_see[pair / 8] >> pair % 8 & 1U) != 0) continue;
      ++hidden;
      const Place &viewer = viewers[pair / 40], &target = targets[pair % 40];
      for (int ray = 0; ray < 6; ++ray) {
        const glm::dvec3 from = pointOf(viewer, random), to = pointOf(target, random);
        ASSERT_TRUE(blocked(*scene, from, to)) << "seed " << seed << ", pair " << pair;
      }
    }
  }
  EXPECT_GT(hidden, pairs / 100);
}

/// Targets within ulps of the shadow's rim: behind a vertex or an edge of a box, seen exactly past
/// it.
TEST(PairsAttack, RoundingDoesNotReachIntoTheLight) {
  std::uint64_t hidden = 0, lit = 0;
  for (std::uint64_t seed = 1; seed <= scenes::rounds(1600); ++seed) {
    Random random(seed);
    scenes::Model model;
    const auto material = model.addMaterial({});
    const bool open = random.chance(0.5);
    const auto shape = open ? scenes::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})
                            : scenes::box(glm::vec3(-1), glm::vec3(1));
    const auto mesh = model.addMesh({"m", {{shape, material}}});
    const double offset = std::pow(10.0, random.uniform(-2, 7));
    const glm::dvec3 moved = offset * glm::dvec3(random.unit(), random.unit(), random.unit());
    scenes::ModelNode node;
    node.mesh = mesh;
    node.parent_from_node = scenes::turnedAndMoved(random.unit(), moved);
    model.addNode(node);
    const SnapshotPtr scene = scenes::toSnapshot(model);
    const auto& m = scene->instance(0).world_from_mesh;
    const auto world = [&](const glm::dvec3& p) {
      glm::dvec3 out;
      for (int i = 0; i < 3; ++i) {
        const double* row = m.data() + 4 * i;
        out[i] = row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
      }
      return out;
    };
    const glm::dvec3 eye =
        world({random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(2, 20)});
    const double side = random.chance(0.5) ? 1.0 : random.uniform(-1, 1);
    const glm::dvec3 on_rim = world({random.chance(0.5) ? 1.0 : -1.0, side, open ? 0.0 : -1.0});
    const PairsCuller culler(*scene);
    for (int i = 0; i < 20; ++i) {
      glm::dvec3 target = eye + (on_rim - eye) * random.uniform(1.1, 4.0);
      const double push = std::pow(10.0, random.uniform(-17, -6)) * (1.0 + offset);
      target +=
          push * glm::dvec3(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
      const Place viewer{{eye, eye}, 0.0}, place{{target, target}, 0.0};
      const bool hides = culler.cull({&viewer, 1}, {&place, 1}).value().hidden == 1;
      const bool dark = blocked(*scene, eye, target);
      hidden += hides ? 1 : 0;
      lit += dark ? 0 : 1;
      ASSERT_TRUE(!hides || dark) << "seed " << seed << ", target " << i;
    }
  }
  EXPECT_GT(hidden, scenes::rounds(1600));  // of twenty times as many
  EXPECT_GT(lit, scenes::rounds(1600));
}

}  // namespace
}  // namespace culld
