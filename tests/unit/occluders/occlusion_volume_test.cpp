#include "culling/occluders/occlusion_volume.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "culling/occluders/volume_occluders.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

/// A box of half side 1 about the origin, seen from (0, 0, 10).
class SeenFromTheFront : public ::testing::Test {
 protected:
  SeenFromTheFront() : scene_(boxScene()), occluders_(VolumeOccluders::of(*scene_)) {
    eye_.origin_world = {0, 0, 10};
  }

  static SnapshotPtr boxScene() {
    SceneBuilder builder;
    const scenes::Triangles box = scenes::box(glm::vec3(-1), glm::vec3(1));
    builder.addMesh(makeMesh({{box.positions, box.indices, true, false}}));
    return builder.finish();
  }

  bool make(const VolumeSettings& settings = {}) {
    return volume_.build(occluders_.occluder(0, 0), scenes::kIdentity, eye_, settings);
  }

  VolumeVerdict test(const glm::dvec3& centre, double half) {
    const glm::dvec3 origin = centre - eye_.origin_world;
    return volume_.test(seenBox(origin, glm::dvec3(-half), glm::dvec3(half)), planes_);
  }

  SnapshotPtr scene_;
  VolumeOccluders occluders_;
  VolumeEye eye_;
  OcclusionVolume volume_;
  std::uint64_t planes_ = 0;
};

TEST_F(SeenFromTheFront, HidesWhatIsWhollyBehindAndNothingElse) {
  ASSERT_TRUE(make());
  EXPECT_EQ(test({0, 0, -10}, 1.0), VolumeVerdict::kHidden);
  EXPECT_EQ(test({0, 0, -10}, 1.9), VolumeVerdict::kHidden);  // the shadow is wider there
  EXPECT_EQ(test({0, 0, -10}, 3.0), VolumeVerdict::kMostly);
  EXPECT_EQ(test({1.5, 0, -10}, 3.0), VolumeVerdict::kMostly);
  EXPECT_EQ(test({5, 0, -10}, 3.0), VolumeVerdict::kPartly);
  EXPECT_EQ(test({15, 0, -10}, 1.0), VolumeVerdict::kOutside);
  EXPECT_EQ(test({0, 0, 5}, 0.1), VolumeVerdict::kOutside);  // between eye and occluder
}

TEST_F(SeenFromTheFront, HidesWhatLiesWithinButNotTheOccluderItself) {
  ASSERT_TRUE(make());
  EXPECT_EQ(test({0, 0, 0}, 0.5), VolumeVerdict::kHidden);
  EXPECT_NE(test({0, 0, 0}, 1.0), VolumeVerdict::kHidden);
}

TEST_F(SeenFromTheFront, IsTheFacingPlaneAndOnePlaneForEachEdgeOfTheContour) {
  ASSERT_TRUE(make());
  EXPECT_EQ(volume_.planes().size(), 5U);
  eye_.origin_world = {10, 10, 10};  // a corner: three faces and six edges
  ASSERT_TRUE(make({.collapse = false}));
  EXPECT_EQ(volume_.planes().size(), 9U);
  ASSERT_TRUE(make({.collapse = true}));
  EXPECT_EQ(volume_.planes().size(), 7U);
}

TEST_F(SeenFromTheFront, CollapsedPlanesHideLessOfWhatIsCloseAndTheSameFarBehind) {
  eye_.origin_world = {10, 10, 10};
  ASSERT_TRUE(make({.collapse = true}));
  EXPECT_NE(test({0.8, 0.8, 0.8}, 0.1), VolumeVerdict::kHidden);
  EXPECT_EQ(test({-9, -9, -9}, 0.5), VolumeVerdict::kHidden);
  ASSERT_TRUE(make({.collapse = false}));
  EXPECT_EQ(test({0.8, 0.8, 0.8}, 0.1), VolumeVerdict::kHidden);
  EXPECT_EQ(test({-9, -9, -9}, 0.5), VolumeVerdict::kHidden);
}

TEST_F(SeenFromTheFront, TheSphereSavesCornersAndChangesNoVerdict) {
  std::uint64_t with_sphere = 0;
  for (const bool sphere : {true, false}) {
    ASSERT_TRUE(make({.sphere_first = sphere}));
    planes_ = 0;
    for (int i = 0; i < 20; ++i) {
      EXPECT_EQ(test({0, 0, -20}, 0.1 * i + 0.1), VolumeVerdict::kHidden);
      EXPECT_NE(test({6.0 + i, 0, -20}, 5.0), VolumeVerdict::kHidden);
    }
    if (sphere) with_sphere = planes_;
  }
  EXPECT_LT(with_sphere, planes_);
}

TEST_F(SeenFromTheFront, WhatIsBehindByNoMoreThanATieIsNotHidden) {
  for (const bool collapse : {true, false}) {
    ASSERT_TRUE(make({.collapse = collapse}));
    for (const double gap : {0.0, 1e-12, 2e-12}) {
      const glm::dvec3 low(-0.5, -0.5, -9.0 * (1.0 + gap)), high(0.5, 0.5, -9.0 * (1.0 + gap));
      EXPECT_NE(volume_.test(seenBox({}, low, high), planes_), VolumeVerdict::kHidden) << gap;
    }
    const glm::dvec3 low(-0.5, -0.5, -9.0 - 1e-9), high(0.5, 0.5, -9.0 - 1e-9);
    EXPECT_EQ(volume_.test(seenBox({}, low, high), planes_), VolumeVerdict::kHidden);
  }
}

TEST_F(SeenFromTheFront, AMovingEyeHidesLess) {
  ASSERT_TRUE(make());
  EXPECT_EQ(test({0, 0, -10}, 1.9), VolumeVerdict::kHidden);
  eye_.radius_m = 0.5;  // the shadow's edge at z = -10 moves by about 0.5 * 11 / 9
  ASSERT_TRUE(make());
  EXPECT_NE(test({0, 0, -10}, 1.9), VolumeVerdict::kHidden);
  EXPECT_EQ(test({0, 0, -10}, 1.3), VolumeVerdict::kHidden);
  eye_.radius_m = 9.5;  // it may be behind the face
  EXPECT_FALSE(make());
}

TEST_F(SeenFromTheFront, WhatAClipPlaneMayCutHidesNothing) {
  eye_.near_m = 8.9;
  EXPECT_TRUE(make());
  eye_.near_m = 9.1;
  EXPECT_FALSE(make());
}

TEST_F(SeenFromTheFront, NothingThatIsNotFiniteIsHidden) {
  ASSERT_TRUE(make());
  constexpr double kInf = std::numeric_limits<double>::infinity();
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  for (const double odd : {kInf, kNan, 1e300}) {
    const SeenBox box = seenBox({0, 0, -20}, {0, 0, -odd}, {0, 0, 0});
    EXPECT_NE(volume_.test(box, planes_), VolumeVerdict::kHidden) << odd;
    const std::array<glm::dvec3, 1> point{glm::dvec3(0, 0, -odd)};
    EXPECT_FALSE(volume_.hidesPoints(point, odd, planes_)) << odd;
  }
}

TEST_F(SeenFromTheFront, AnOccluderInsideOutOrFlatMakesNoVolume) {
  std::array<double, 12> flat = scenes::kIdentity;
  flat[10] = 0.0;
  EXPECT_FALSE(volume_.build(occluders_.occluder(0, 0), flat, eye_, {}));
  std::array<double, 12> mirrored = scenes::kIdentity;
  mirrored[0] = -1.0;  // turns no fronts inwards
  EXPECT_TRUE(volume_.build(occluders_.occluder(0, 0), mirrored, eye_, {}));
  EXPECT_EQ(test({0, 0, -10}, 1.0), VolumeVerdict::kHidden);
}

TEST(VolumeEye, SaysWhyNot) {
  const Camera ahead = cameraFromLookAt({}, {}).value();
  EXPECT_TRUE(volumeEye(ahead).why_not.empty());
  EXPECT_NEAR(volumeEye(ahead).near_m, 0.1 * std::hypot(1.0, std::tan(0.5), std::tan(0.5) * 16 / 9),
              1e-6);
  LookAt narrow;
  narrow.yfov_rad = 0.01;
  EXPECT_LT(volumeEye(cameraFromLookAt(narrow, {}).value()).near_m, 0.1001);
  glm::dmat4 parallel(1.0);
  parallel[2][2] = -0.01;
  const auto turning = cameraFromMatrices(glm::dmat4(1.0), parallel, {}, {0.0, 0.1});
  ASSERT_TRUE(turning.ok());
  EXPECT_FALSE(volumeEye(turning.value()).why_not.empty());
}

}  // namespace
}  // namespace culld
