// Attacks docs/error-model/occlusion-volumes.md: whatever a volume calls hidden must be hidden,
// from every eye within the radius, by a triangle of the mesh that turns its front to that eye.
// Points are driven to the volume's edge by bisection; any transform, place and scale; judged in
// 113 bits.
#include <gtest/gtest.h>

#include <random>

#include "culling/occluders/occlusion_volume.h"
#include "culling/occluders/volume_occluders.h"
#include "culling/raster/object_rows.h"
#include "tests/scenes/rounds.h"
#include "tests/unit/raster/cell_attack.h"

namespace culld {
namespace {

using Generator = std::mt19937_64;

double between(Generator& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

glm::dvec3 inBall(Generator& random, double radius) {
  for (;;) {
    const glm::dvec3 p(between(random, -1, 1), between(random, -1, 1), between(random, -1, 1));
    if (glm::dot(p, p) <= 1.0) return radius * p;
  }
}

Vec exact(const glm::dvec3& p) { return {p.x, p.y, p.z}; }

/// The object's triangles where they truly are.
class TrueObject {
 public:
  TrueObject(const Mesh& mesh, const std::array<double, 12>& m) : mesh_(mesh) {
    for (const glm::vec3& p : mesh.positions) {
      const auto row = [&](std::size_t i) {
        return Quad(m[4 * i]) * Quad(p.x) + Quad(m[4 * i + 1]) * Quad(p.y) +
               Quad(m[4 * i + 2]) * Quad(p.z) + Quad(m[4 * i + 3]);
      };
      points_.push_back({row(0), row(1), row(2)});
    }
    sign_ = handedness(m);
  }

  /// Does the segment from `eye` to `to` pass through a triangle from its front to its back?
  bool blocks(const Vec& eye, const Vec& to) const {
    return std::any_of(
        mesh_.triangles.begin(), mesh_.triangles.end(), [&](const std::array<std::uint32_t, 3>& t) {
          const Vec a = points_[t[0]] - eye, b = points_[t[1]] - eye, c = points_[t[2]] - eye;
          const Vec n = Quad(sign_) * cross(b - a, c - a), x = to - eye;
          const Quad eye_side = dot(n, a), at = dot(n, x);
          if (!(eye_side < 0) || !(at < eye_side)) return false;
          const auto inside = [&](const Vec& p, const Vec& q) {
            return Quad(sign_) * dot(x, cross(q, p)) >= 0;
          };
          return inside(a, b) && inside(b, c) && inside(c, a);
        });
  }

 private:
  const Mesh& mesh_;
  std::vector<Vec> points_;
  double sign_;
};

scenes::Triangles someShape(Generator& random) {
  scenes::Triangles shape;
  const scenes::Triangles box = scenes::box(glm::vec3(-1), glm::vec3(1));
  switch (random() % 5) {
    case 0:
      return box;
    case 1:  // bent faces
      scenes::append(shape, box, scenes::turnedAndMoved(between(random, 0, 6), {0.3, 0, 0}));
      return shape;
    case 2:
      return scenes::prism(scenes::regularFootprint(3 + random() % 8, 1.0F), -1.0F, 1.0F);
    case 3:
      return scenes::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0});
    default:
      scenes::append(shape, box, scenes::scaledAndMoved({1, 1, 1e-3}, {0, 0, 0}));
      return shape;
  }
}

std::array<double, 12> somewhere(Generator& random, double scale, const glm::dvec3& place) {
  std::array<double, 12> m{};
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      m[4 * i + j] = scale * (between(random, -1, 1) + (i == j ? 1.5 : 0.0));
    m[4 * i + 3] = place[static_cast<int>(i)];
  }
  if (random() % 3 == 0) {
    for (std::size_t i = 0; i < 3; ++i) m[4 * i] = -m[4 * i];
  }
  return m;
}

struct Attack {
  std::size_t volumes = 0, points = 0;
};

void attackOne(std::uint64_t seed, bool perspective, bool moving, Attack& attack) {
  SCOPED_TRACE("seed " + std::to_string(seed));
  Generator random(seed);
  const scenes::Triangles shape = someShape(random);
  SceneBuilder builder;
  builder.addMesh(makeMesh({{shape.positions, shape.indices, true, false}}));
  const SnapshotPtr scene = builder.finish();
  const VolumeOccluders occluders = VolumeOccluders::of(*scene);
  ASSERT_EQ(occluders.countOf(0), 1U);
  const double scale = std::pow(10.0, between(random, -4, 4));
  const double distance = scale * std::pow(10.0, between(random, 0.2, 3));
  const std::array<double, 12> placed =
      somewhere(random, scale, inBall(random, random() % 2 == 0 ? 0.0 : 1e7));
  const glm::dvec3 place(placed[3], placed[7], placed[11]);
  VolumeEye eye;
  eye.origin_world = place + glm::normalize(inBall(random, 1.0)) * distance;
  eye.perspective = perspective;
  if (!perspective) {
    eye.along = glm::normalize(place - eye.origin_world + inBall(random, 0.1 * distance));
    eye.along_error = 4 * 0x1p-53;
    eye.cut_row[0] = eye.cut_row[1] = {0, 0, 0, 1};
  } else if (moving) {
    eye.radius_m = between(random, 0.0, 0.5) * scale;
  }
  const VolumeSettings settings{random() % 2 == 0, random() % 2 == 0};
  OcclusionVolume volume;
  if (!volume.build(occluders.occluder(0, 0), placed, eye, settings)) return;
  ++attack.volumes;
  const TrueObject object(scene->mesh(0), placed);
  const glm::dvec3 to_object = place - eye.origin_world;
  const auto hidden = [&](const glm::dvec3& x) {
    std::uint64_t planes = 0;
    return volume.test(seenBox({}, x, x), planes) == VolumeVerdict::kHidden;
  };
  const double reach = std::pow(10.0, between(random, 0.0, 2.0));
  glm::dvec3 in = reach * to_object;
  for (int k = 0; k < 40; ++k) {
    const glm::dvec3 start = reach * (to_object + inBall(random, 2.0 * scale));
    if (!hidden(in) && hidden(start)) in = start;
    if (!hidden(in)) continue;
    glm::dvec3 good = in, bad = start;
    if (k % 2 == 0)
      bad = random() % 2 == 0 ? 0.5 * to_object : in + inBall(random, 9.0 * reach * scale);
    for (int step = 0; step < 60 && !hidden(bad); ++step) {
      const glm::dvec3 middle = 0.5 * good + 0.5 * bad;
      (hidden(middle) ? good : bad) = middle;
    }
    ++attack.points;
    for (int pose = 0; pose < (moving ? 12 : 1); ++pose) {
      const glm::dvec3 moved =
          moving ? eye.radius_m * glm::normalize(inBall(random, 1.0)) : glm::dvec3(0.0);
      const Vec target = exact(eye.origin_world) + exact(good);
      const Vec from = perspective
                           ? exact(eye.origin_world) + exact(moved)
                           : target - Quad(1e3 * (reach * distance + scale)) * exact(eye.along);
      ASSERT_TRUE(object.blocks(from, target)) << "pose " << pose << " point " << k;
    }
  }
}

Attack attackAll(std::uint64_t first, bool perspective, bool moving) {
  Attack attack;
  const std::uint64_t count = scenes::rounds(3000);
  for (std::uint64_t seed = first; seed < first + count && !::testing::Test::HasFatalFailure();
       ++seed)
    attackOne(seed, perspective, moving, attack);
  return attack;
}

TEST(OcclusionVolumeAttack, HiddenPointsAreHiddenByAFrontFace) {
  const Attack attack = attackAll(1, true, false);
  EXPECT_GT(attack.volumes, scenes::rounds(1000));
  EXPECT_GT(attack.points, scenes::rounds(20'000));
}

TEST(OcclusionVolumeAttack, AlsoFromEveryEyeWithinTheMotionBound) {
  const Attack attack = attackAll(100'000, true, true);
  EXPECT_GT(attack.volumes, scenes::rounds(500));
  EXPECT_GT(attack.points, scenes::rounds(5'000));
}

TEST(OcclusionVolumeAttack, AlsoAlongParallelRays) {
  const Attack attack = attackAll(200'000, false, false);
  EXPECT_GT(attack.volumes, scenes::rounds(1000));
  EXPECT_GT(attack.points, scenes::rounds(20'000));
}

}  // namespace
}  // namespace culld
