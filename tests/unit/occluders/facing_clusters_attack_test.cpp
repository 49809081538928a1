// Attacks docs/error-model/backface-clusters.md: whatever clusters call turned away must be so, for
// every eye within the radius and every triangle. Eyes are driven to the rim of the back region by
// bisection; any transform, place and scale; judged in 113 bits.
#include <gtest/gtest.h>

#include "culling/occluders/facing_clusters.h"
#include "tests/scenes/rounds.h"
#include "tests/unit/raster/cell_attack.h"

namespace culld {
namespace {

using scenes::Random;

glm::dvec3 inBall(Random& random, double radius) {
  for (;;) {
    const double x = random.uniform(-1, 1), y = random.uniform(-1, 1), z = random.uniform(-1, 1);
    const glm::dvec3 p(x, y, z);
    if (glm::dot(p, p) <= 1.0) return radius * p;
  }
}

/// Open sheets, most of them; some with slivers.
Mesh someMesh(Random& random) {
  scenes::Triangles shape;
  switch (random.below(4)) {
    case 0:
      shape = scenes::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
      break;
    case 1:
      shape = scenes::bumpySheet(1 + random.below(9), random.uniform(0.0, 0.4), random);
      break;
    case 2:
      shape = scenes::ball(3 + random.below(4), 0.1, random);
      shape.indices.resize(3 * (1 + random.below(12)));
      break;
    default:
      shape = scenes::bumpySheet(2, 0.2, random);
      for (glm::vec3& p : shape.positions) p.x *= 1e-4F;  // slivers
  }
  const float size = std::pow(10.0F, static_cast<float>(random.uniform(-2, 2)));
  const glm::vec3 aside(inBall(random, random.chance(0.5) ? 0.0 : 100.0));
  for (glm::vec3& p : shape.positions) p = size * (p + aside);
  return makeMesh({{shape.positions, shape.indices, true, false}});
}

std::array<double, 12> somewhere(Random& random) {
  const double scale = std::pow(10.0, random.uniform(-3, 3));
  const glm::dvec3 place = inBall(random, random.chance(0.5) ? 0.0 : 1e7);
  std::array<double, 12> m{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      m[4 * i + j] = scale * (random.uniform(-1, 1) + (i == j ? 1.5 : 0.0));
    m[4 * i + 3] = place[static_cast<int>(i)];
  }
  if (random.chance(0.3)) m[0] = -m[0], m[4] = -m[4], m[8] = -m[8];
  return m;
}

struct Attack {
  std::uint64_t away = 0, left_out = 0;
};

class OneMesh {
 public:
  OneMesh(std::uint64_t seed, bool perspective, Attack& attack)
      : random_(seed),
        perspective_(perspective),
        attack_(attack),
        mesh_(someMesh(random_)),
        clusters_(FacingClusters::of(mesh_, {1 + random_.below(9), true, random_.chance(0.7)})),
        placed_(somewhere(random_)) {}

  void run() {
    const glm::dvec3 middle = 0.5 * (mesh_.bounds.min + mesh_.bounds.max);
    const glm::dvec3 centre = toWorld(placed_, middle);
    const double size =
        glm::length(toWorld(placed_, mesh_.bounds.max) - toWorld(placed_, mesh_.bounds.min));
    radius_ = perspective_ && random_.chance(0.5) ? random_.uniform(0, 0.3) * size : 0.0;
    for (int k = 0; k < 12; ++k) {
      const double reach = size * std::pow(10.0, random_.uniform(-1, 3));
      glm::dvec3 good = centre + inBall(random_, reach), bad = centre + inBall(random_, reach);
      if (!away(good)) std::swap(good, bad);
      if (!away(good)) continue;
      for (int step = 0; step < 60 && !away(bad); ++step) {
        const glm::dvec3 between = 0.5 * good + 0.5 * bad;
        (away(between) ? good : bad) = between;
      }
      judgeAll(good);
    }
    judgeLeftOut(centre + inBall(random_, 10.0 * size));
  }

 private:
  VolumeEye viewer(const glm::dvec3& eye) const {
    VolumeEye out;
    out.origin_world = eye;
    out.perspective = perspective_;
    out.radius_m = radius_;
    if (!perspective_) {  // the place stands for a direction
      out.along = -glm::normalize(eye - toWorld(placed_, mesh_.bounds.min));
      out.along_error = 0x1p-50;
    }
    return out;
  }
  bool away(const glm::dvec3& eye) const {
    std::uint64_t regions = 0;
    const auto mesh_eye = meshEye(placed_, viewer(eye));
    return mesh_eye && clusters_.turnedAway(*mesh_eye, true, 1'000'000, regions);
  }
  bool facesAny(const TrueObject& object, const glm::dvec3& eye, std::uint32_t t) {
    const std::array<Vec, 3> corner = object.triangle(t);
    const glm::dvec3 along = viewer(eye).along;
    for (int pose = 0; pose < (radius_ > 0.0 ? 8 : 1); ++pose) {
      const glm::dvec3 d =
          radius_ > 0.0 ? radius_ * glm::normalize(inBall(random_, 1.0)) : glm::dvec3(0);
      const Vec ray =
          perspective_ ? corner[0] - Vec{d.x, d.y, d.z} : Vec{along.x, along.y, along.z};
      if (dot(ray, ray) > 0 && object.front(corner, {{0, 0, 0}, ray})) return true;
    }
    return false;
  }
  void judgeAll(const glm::dvec3& eye) {
    const TrueObject object(mesh_, placed_, eye);
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      ASSERT_FALSE(facesAny(object, eye, t)) << "triangle " << t;
    }
    ++attack_.away;
  }
  /// Triangles that no run names, in the mesh's own numbers, by their corners.
  void judgeLeftOut(const glm::dvec3& eye) {
    const auto mesh_eye = meshEye(placed_, viewer(eye));
    if (!mesh_eye) return;
    const TrueObject object(mesh_, placed_, eye);
    std::uint64_t regions = 0;
    std::vector<SheetSurface> runs;
    clusters_.appendFacing(mesh_, *mesh_eye, true, runs, regions);
    std::vector<bool> named(mesh_.triangles.size());
    for (const SheetSurface& run : runs) {
      for (std::uint32_t i = 0; i < run.triangle_count; ++i) named[run.first_triangle + i] = true;
    }
    for (std::uint32_t t = 0; t < named.size(); ++t) {
      if (named[t]) continue;
      ++attack_.left_out;
      const auto at =
          std::find(mesh_.triangles.begin(), mesh_.triangles.end(), clusters_.triangles()[t]);
      ASSERT_FALSE(facesAny(object, eye, static_cast<std::uint32_t>(at - mesh_.triangles.begin())));
    }
  }

  Random random_;
  bool perspective_;
  Attack& attack_;
  Mesh mesh_;
  FacingClusters clusters_;
  std::array<double, 12> placed_;
  double radius_ = 0.0;
};

Attack attackAll(std::uint64_t first, bool perspective) {
  Attack attack;
  const std::uint64_t end = first + scenes::rounds(1500);
  for (std::uint64_t seed = first; seed < end && !::testing::Test::HasFatalFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    OneMesh(seed, perspective, attack).run();
  }
  return attack;
}

TEST(FacingClustersAttack, WhatIsTurnedAwayIsSoForEveryEye) {
  const Attack attack = attackAll(1, true);
  EXPECT_GT(attack.away, scenes::rounds(4'000));
  EXPECT_GT(attack.left_out, scenes::rounds(7'000));
}

TEST(FacingClustersAttack, AndAlongParallelRays) {
  const Attack attack = attackAll(100'000, false);
  EXPECT_GT(attack.away, scenes::rounds(4'000));
  EXPECT_GT(attack.left_out, scenes::rounds(7'000));
}

}  // namespace
}  // namespace culld
