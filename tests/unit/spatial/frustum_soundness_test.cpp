// Attacks the inequalities of docs/error-model/frustum.md: boxes that touch a plane within a few
// units in the last place, judged in quadruple precision.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "culling/spatial/frustum_test.h"
#include "culling/spatial/wide_bvh_fit.h"
#include "tests/unit/spatial/box_scene.h"
#include "tests/unit/spatial/exact.h"

namespace culld::testing {
namespace {

using Random = std::mt19937_64;

double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

glm::dvec3 anyDirection(Random& random) {
  while (true) {
    const glm::dvec3 v(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
    const double length = std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
    if (length > 0.1 && length < 1.0) return v / length;
  }
}

struct World {
  const char* name;
  double scale;
  glm::dvec3 centre;
  double near, far;  ///< in units of scale; far 0: infinite
  std::size_t boxes;
};

void PrintTo(const World& world, std::ostream* out) { *out << world.name; }

Camera anyCamera(Random& random, const World& world) {
  LookAt look;
  look.eye = world.centre + world.scale * anyDirection(random);
  // Every fourth camera looks along an axis, where normals have zeros and equal entries.
  glm::dvec3 ahead = anyDirection(random);
  if (random() % 4 == 0) ahead = {random() % 2 == 0 ? 1.0 : 0.0, 0.0, -1.0};
  look.target = look.eye + std::max(1.0, std::abs(world.centre.x) * 1e-3) * world.scale * ahead;
  look.yfov_rad = uniform(random, 0.01, 3.0);
  look.aspect = std::exp(uniform(random, -2, 2));
  look.znear_m = world.near * world.scale;
  if (world.far > 0.0) look.zfar_m = world.far * world.scale;
  auto camera = cameraFromLookAt(look, {});
  EXPECT_TRUE(camera.ok());
  return camera.value();
}

/// Moves the box along one axis until its most inward corner is `beyond` past the plane, or almost.
void moveOnto(const QuadPlane& plane, const Camera& camera, double beyond, Box& box) {
  int axis = 0;
  for (int a = 1; a < 3; ++a) {
    if (quadAbs(plane.n[a]) > quadAbs(plane.n[axis])) axis = a;
  }
  const QuadValue at = largestInBox(plane, camera, box);
  const double shift = static_cast<double>(-at.value / plane.n[axis]) + beyond;
  box.min[axis] += shift;
  box.max[axis] += shift;
}

/// A box near the eye whose most inward corner is moved onto `plane`, up to a few ulp.
Box tangentBox(Random& random, const World& world, const Camera& camera, const QuadPlane& plane) {
  const double scale = world.scale * std::pow(10.0, uniform(random, -2, 2));
  const glm::dvec3 low = camera.origin_world + scale * anyDirection(random);
  Box box;
  box.grow(low);
  box.grow(low +
           scale * std::pow(10.0, uniform(random, -4, 0)) *
               glm::dvec3(uniform(random, 0, 1), uniform(random, 0, 1), uniform(random, 0, 1)));
  const double ulp = random() % 2 == 0 ? 0x1p-24 : 0x1p-53;
  moveOnto(plane, camera, scale * ulp * uniform(random, -8.0, 8.0), box);
  return box;
}

class FrustumSoundness : public ::testing::TestWithParam<World> {};

TEST_P(FrustumSoundness, CullsNoBoxThatTouchesThePlanesFromInside) {
  const World& world = GetParam();
  Random random(11);
  const WideBvh no_tree = WideBvh::build(*boxScene({}));
  std::size_t touching = 0, culled = 0;
  for (std::size_t n = 0; n < world.boxes / 8; ++n) {
    const Camera camera = anyCamera(random, world);
    const auto planes = exactPlanes(camera);
    Box boxes[kWideLanes];
    // A far plane at infinity has no direction to be tangent to.
    for (Box& box : boxes) box = tangentBox(random, world, camera, planes[random() % 5]);
    WideNode node = emptyNode();
    fitNode(node, boxes);
    const FrustumTest frustum(camera, no_tree);
    const LaneVerdicts verdicts = frustum.test(node, frustum.planes());
    for (std::size_t l = 0; l < kWideLanes; ++l) {
      const bool kept = (verdicts.may_intersect >> l & 1U) != 0;
      const bool outside = outsideExactly(camera, boxes[l]);
      touching += outside ? 0U : 1U;
      culled += kept ? 0U : 1U;
      ASSERT_TRUE(kept || outside) << "node " << n << " lane " << l;
    }
  }
  EXPECT_GT(touching, world.boxes / 20);  // the attack was one
  EXPECT_GT(culled, world.boxes / 20);    // and the test did not just keep everything
}

TEST_P(FrustumSoundness, CullsWhatIsOutsideByMoreThanAFewUlp) {
  const World& world = GetParam();
  Random random(12);
  const WideBvh no_tree = WideBvh::build(*boxScene({}));
  for (std::size_t n = 0; n < 5000; ++n) {
    const Camera camera = anyCamera(random, world);
    Box boxes[kWideLanes];
    const double scale = world.scale * std::pow(10.0, uniform(random, -2, 2));
    for (Box& box : boxes) {
      const glm::dvec3 low = camera.origin_world + scale * anyDirection(random);
      box.grow(low);
      box.grow(low + scale * 0.1);
    }
    WideNode node = emptyNode();
    fitNode(node, boxes);
    const FrustumTest frustum(camera, no_tree);
    const LaneVerdicts verdicts = frustum.test(node, frustum.planes());
    for (std::size_t l = 0; l < kWideLanes; ++l) {
      if (!clearlyOutside(camera, boxes[l], 0x1p-16)) continue;
      ASSERT_EQ(verdicts.may_intersect >> l & 1U, 0U) << "node " << n << " lane " << l;
    }
  }
}

TEST_P(FrustumSoundness, SkipsAPlaneOnlyIfTheWholeBoxIsInside) {
  const World& world = GetParam();
  Random random(13);
  const WideBvh no_tree = WideBvh::build(*boxScene({}));
  std::size_t skipped = 0;
  for (std::size_t n = 0; n < 20000; ++n) {
    const Camera camera = anyCamera(random, world);
    const auto planes = exactPlanes(camera);
    Box boxes[kWideLanes];
    for (Box& box : boxes) {
      const std::size_t p = random() % 5;
      QuadPlane flipped = planes[p];  // tangent from the other side: the outermost corner touches
      for (Quad& c : flipped.n) c = -c;
      flipped.d = -flipped.d;
      box = tangentBox(random, world, camera, flipped);
    }
    WideNode node = emptyNode();
    fitNode(node, boxes);
    const FrustumTest frustum(camera, no_tree);
    const LaneVerdicts verdicts = frustum.test(node, frustum.planes());
    for (std::size_t l = 0; l < kWideLanes; ++l) {
      for (std::uint32_t p = 0; p < 5; ++p) {
        if ((verdicts.inside[p] >> l & 1U) == 0) continue;
        ++skipped;
        QuadPlane flipped = planes[p];
        for (Quad& c : flipped.n) c = -c;
        flipped.d = -flipped.d;
        const QuadValue least = largestInBox(flipped, camera, boxes[l]);
        ASSERT_LT(static_cast<double>(least.value), 0.0) << "node " << n << " lane " << l;
      }
    }
  }
  EXPECT_GT(skipped, 10000U);
}

INSTANTIATE_TEST_SUITE_P(
    Worlds, FrustumSoundness,
    ::testing::Values(World{"metres", 1.0, {0, 0, 0}, 0.1, 0.0, 1000000},
                      World{"metres_at_1e7", 1.0, {1e7, -1e7, 1e7}, 0.1, 1e4, 400000},
                      World{"centimetres_on_the_earth", 1e-2, {6.4e6, 3.0, -1e5}, 0.1, 0.0, 400000},
                      World{"kilometres_at_1e7", 1e3, {1e7, 1e7, 0}, 1e-3, 1e3, 200000},
                      World{"tiny", 1e-30, {0, 0, 0}, 1e-3, 1e3, 200000},
                      World{"huge", 1e30, {0, 0, 0}, 1e-3, 1e3, 200000},
                      World{"near_far_1e15", 1.0, {0, 0, 0}, 1e-3, 1e12, 200000}),
    [](const auto& world) { return std::string(world.param.name); });

// The errors of the double precision steps show only where the float steps make none worth mention:
// eight specks close together, far from the eye.
TEST(FrustumSoundnessFarAway, CullsNoSpeckThatTouchesAPlane) {
  Random random(14);
  const WideBvh no_tree = WideBvh::build(*boxScene({}));
  std::size_t touching = 0, culled = 0;
  for (int n = 0; n < 50000; ++n) {
    const Camera camera = anyCamera(random, {"", 1.0, {1e4, 0, 0}, 0.1, 0.0, 0});
    const QuadPlane plane = exactPlanes(camera)[random() % 4];
    const glm::dvec3 normal =
        glm::normalize(glm::dvec3(static_cast<double>(plane.n[0]), static_cast<double>(plane.n[1]),
                                  static_cast<double>(plane.n[2])));
    const double distance = std::pow(10.0, uniform(random, 2, 9));
    const double ulp = distance * 0x1p-53;
    const glm::dvec3 along = anyDirection(random);
    const glm::dvec3 place =
        camera.origin_world + distance * (along - normal * glm::dot(normal, along));
    Box boxes[kWideLanes];
    for (Box& box : boxes) {
      box.grow(place + ulp * uniform(random, 1, 1e4) * anyDirection(random));
      box.grow(box.min + ulp * glm::dvec3(random() % 64, random() % 64, random() % 64));
      moveOnto(plane, camera, ulp * uniform(random, -40, 40), box);
    }
    WideNode node = emptyNode();
    fitNode(node, boxes);
    const FrustumTest frustum(camera, no_tree);
    const LaneVerdicts verdicts = frustum.test(node, frustum.planes());
    for (std::size_t l = 0; l < kWideLanes; ++l) {
      const bool kept = (verdicts.may_intersect >> l & 1U) != 0;
      const bool outside = outsideExactly(camera, boxes[l]);
      touching += outside ? 0U : 1U;
      culled += kept ? 0U : 1U;
      ASSERT_TRUE(kept || outside) << "node " << n << " lane " << l;
    }
  }
  EXPECT_GT(touching, 30000U);
  EXPECT_GT(culled, 40000U);
}

// Where float products lose their last bits to underflow.
TEST(FrustumSoundnessSubnormal, CullsNoBoxThatTouchesAPlane) {
  Random random(15);
  const WideBvh no_tree = WideBvh::build(*boxScene({}));
  std::size_t touching = 0;
  for (int n = 0; n < 50000; ++n) {
    const World world{"", std::pow(10.0, uniform(random, -46, -34)), {0, 0, 0}, 1e-3, 0.0, 0};
    const Camera camera = anyCamera(random, world);
    const auto planes = exactPlanes(camera);
    Box boxes[kWideLanes];
    for (Box& box : boxes) box = tangentBox(random, world, camera, planes[random() % 5]);
    WideNode node = emptyNode();
    fitNode(node, boxes);
    const FrustumTest frustum(camera, no_tree);
    const LaneVerdicts verdicts = frustum.test(node, frustum.planes());
    for (std::size_t l = 0; l < kWideLanes; ++l) {
      const bool kept = (verdicts.may_intersect >> l & 1U) != 0;
      const bool outside = outsideExactly(camera, boxes[l]);
      touching += outside ? 0U : 1U;
      ASSERT_TRUE(kept || outside) << "node " << n << " lane " << l;
    }
  }
  EXPECT_GT(touching, 20000U);
}

/// The camera as it looks from another pose: rotated about its eye, then moved.
Camera moved(const Camera& camera, const glm::dvec3& axis, double angle, const glm::dvec3& step) {
  Camera pose = camera;
  pose.origin_world += step;
  for (glm::dvec4* row : {&pose.x_row, &pose.y_row, &pose.z_row, &pose.w_row, &pose.near_cut_row,
                          &pose.far_cut_row}) {
    const glm::dvec3 v(*row);
    const glm::dvec3 turned = v * std::cos(angle) + glm::cross(axis, v) * std::sin(angle) +
                              axis * (glm::dot(axis, v) * (1.0 - std::cos(angle)));
    *row = glm::dvec4(turned, row->w);
  }
  return pose;
}

/// A point inside the frustum of a perspective camera, often close to its sides.
glm::dvec3 pointInside(Random& random, const Camera& camera, double depth) {
  const auto edge = [&] {
    const double x = uniform(random, -1.0, 1.0);
    return random() % 2 == 0 ? x : std::copysign(1.0 - 1e-9, x);
  };
  // Solve x = ex * w, y = ey * w, w = depth with the rows' own lengths (they are orthogonal).
  const glm::dvec3 x(camera.x_row), y(camera.y_row), w(camera.w_row);
  return camera.origin_world + x * (edge() * depth / glm::dot(x, x)) +
         y * (edge() * depth / glm::dot(y, y)) + w * (depth / glm::dot(w, w));
}

TEST(FrustumMotion, KeepsWhatIsSeenFromAnyPoseWithinTheBound) {
  Random random(21);
  const WideBvh no_tree = WideBvh::build(*boxScene({}));
  for (int n = 0; n < 200000; ++n) {
    LookAt look;
    look.eye = 1e5 * anyDirection(random);
    look.target = look.eye + anyDirection(random);
    look.yfov_rad = uniform(random, 0.05, 2.8);
    look.znear_m = 0.5;
    if (random() % 2 == 0) look.zfar_m = 200.0;
    MotionBound motion;
    motion.radius_m = random() % 3 == 0 ? 0.0 : std::pow(10.0, uniform(random, -3, 1.5));
    motion.angle_rad = random() % 3 == 0 ? 0.0 : std::pow(10.0, uniform(random, -3, 0.6));
    const Camera camera = cameraFromLookAt(look, {}, motion).value();
    const double angle =
        std::min(motion.angle_rad, 3.14159) * (random() % 2 == 0 ? 1.0 : uniform(random, 0, 1));
    const double radius =
        motion.radius_m * (random() % 2 == 0 ? 1.0 - 1e-9 : uniform(random, 0, 1));
    const Camera pose = moved(camera, anyDirection(random), angle, radius * anyDirection(random));
    Box boxes[kWideLanes];
    for (Box& box : boxes) {
      const double depth = random() % 3 == 0 ? 0.5 * (1.0 + 1e-9) : uniform(random, 0.5, 199.99);
      const glm::dvec3 p = pointInside(random, pose, depth);
      box.grow(p);
      if (random() % 2 == 0) box.grow(p + 5.0 * uniform(random, 0, 1) * anyDirection(random));
    }
    WideNode node = emptyNode();
    fitNode(node, boxes);
    const FrustumTest frustum(camera, no_tree);
    ASSERT_EQ(frustum.test(node, frustum.planes()).may_intersect, 0xFFU) << n;
  }
}

TEST(FrustumMotion, StillCullsWhatNoPoseSees) {
  const WideBvh no_tree = WideBvh::build(*boxScene({}));
  LookAt look;  // at the origin, towards -z, 90 degrees high and wide
  look.yfov_rad = std::acos(0.0);
  look.aspect = 1.0;
  Box boxes[kWideLanes];
  for (std::size_t l = 0; l < kWideLanes; ++l) {
    const double x = 10.0 + 2.0 * static_cast<double>(l);
    boxes[l].grow({x, -0.1, -10.1});
    boxes[l].grow({x + 0.5, 0.1, -10.0});
  }
  WideNode node = emptyNode();
  fitNode(node, boxes);
  const auto kept = [&](MotionBound motion) {
    const FrustumTest frustum(cameraFromLookAt(look, {}, motion).value(), no_tree);
    return frustum.test(node, frustum.planes()).may_intersect;
  };
  EXPECT_EQ(kept({}), 0x01U);           // x = 10 lies on the plane x = -z
  EXPECT_EQ(kept({1.5, 0.0}), 0x03U);   // 12 - 10.1 = 1.9 off in x, 1.35 off the plane
  EXPECT_EQ(kept({0.0, 0.15}), 0x07U);  // 14: 2.76 off the plane, 0.15 * 17.9 = 2.69 at its far end
  EXPECT_EQ(kept({1000.0, 0.0}), 0xFFU);
  EXPECT_EQ(kept({0.0, 4.0}), 0xFFU);
}

TEST(FrustumTest, LeavesOutAFarPlaneAtInfinity) {
  const WideBvh no_tree = WideBvh::build(*boxScene({}));
  LookAt look;
  EXPECT_EQ(FrustumTest(cameraFromLookAt(look, {}).value(), no_tree).planes(), 0x1FU);
  look.zfar_m = 100.0;
  EXPECT_EQ(FrustumTest(cameraFromLookAt(look, {}).value(), no_tree).planes(), 0x3FU);
}

TEST(FrustumTest, LeavesOutTheRoundingDustOfAFarPlaneAtInfinity) {
  const WideBvh no_tree = WideBvh::build(*boxScene({}));
  Random random(31);
  for (int n = 0; n < 1000; ++n) {
    // A view matrix with a rotation full of rounding, an infinite projection: z = -p.z - 2 near w.
    const glm::dvec3 f = anyDirection(random);
    const glm::dvec3 s = glm::normalize(glm::cross(f, anyDirection(random)));
    const glm::dvec3 u = glm::cross(s, f);
    const glm::dvec3 eye = 1e6 * anyDirection(random);
    const glm::dmat4 view(glm::dvec4(s.x, u.x, -f.x, 0), glm::dvec4(s.y, u.y, -f.y, 0),
                          glm::dvec4(s.z, u.z, -f.z, 0),
                          glm::dvec4(-glm::dot(s, eye), -glm::dot(u, eye), glm::dot(f, eye), 1));
    const glm::dmat4 projection(glm::dvec4(1, 0, 0, 0), glm::dvec4(0, 1, 0, 0),
                                glm::dvec4(0, 0, -1.0 + 0x1p-52, -1), glm::dvec4(0, 0, -0.002, 0));
    const auto camera = cameraFromMatrices(view, projection, {});
    ASSERT_TRUE(camera.ok());
    ASSERT_EQ(FrustumTest(camera.value(), no_tree).planes(), 0x1FU);
  }
}

TEST(FrustumTest, KeepsABoxAroundTheEye) {
  Random random(41);
  const WideBvh no_tree = WideBvh::build(*boxScene({}));
  for (int n = 0; n < 1000; ++n) {
    const Camera camera = anyCamera(random, {"", 1.0, {1e6, 0, 0}, 1e-3, 1e3, 0});
    Box boxes[kWideLanes];
    for (Box& box : boxes) {
      box.grow(camera.origin_world - glm::dvec3(0.01));
      box.grow(camera.origin_world + glm::dvec3(uniform(random, 0.01, 100)));
    }
    WideNode node = emptyNode();
    fitNode(node, boxes);
    const FrustumTest frustum(camera, no_tree);
    ASSERT_EQ(frustum.test(node, frustum.planes()).may_intersect, 0xFFU);
  }
}

}  // namespace
}  // namespace culld::testing
