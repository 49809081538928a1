// Cameras that may be anywhere within a motion bound: the oracle looks from many poses.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "culling/oracle/oracle.h"
#include "culling/oracle/poses.h"
#include "tests/scenes/random_scene.h"
#include "tests/unit/oracle/small_scenes.h"

namespace culld {
namespace {

using oracle_test::at;
using oracle_test::cameraAt;
using oracle_test::cube;
using oracle_test::Scene;
using oracle_test::wall;
using Ids = std::vector<ObjectId>;

OracleAnswer look(const SnapshotPtr& scene, Camera camera, MotionBound motion,
                  OracleOptions options = {}) {
  camera.motion = motion;
  auto oracle = Oracle::build(scene);
  EXPECT_TRUE(oracle.ok());
  auto answer = oracle.value()->look(camera, options);
  EXPECT_TRUE(answer.ok());
  return std::move(answer).value();
}

TEST(OracleMotion, SeesBehindAWallFromWhereTheRadiusReaches) {
  // The wall's rim is 2 aside at 5, the box's 0.5 at 10: an eye more than 3.5 aside sees it.
  Scene scene;
  const ObjectId front = scene.add(wall(true, true), at(0, 0, -5, 4, 4));
  const ObjectId behind = scene.add(wall(true, true), at(0, 0, -10));
  const SnapshotPtr snapshot = scene.finish();
  const Camera camera = cameraAt({0, 0, 0});
  EXPECT_EQ(look(snapshot, camera, {0.0, 0.0}).visible, Ids{front});
  EXPECT_EQ(look(snapshot, camera, {3.4, 0.0}).visible, Ids{front});
  EXPECT_EQ(look(snapshot, camera, {3.6, 0.0}).visible, (Ids{front, behind}));
  EXPECT_EQ(look(snapshot, camera, {3.6, 0.0}, {.poses = 0}).visible, Ids{front});
}

TEST(OracleMotion, SeesToEverySideWhatTurnsReach) {
  // Half the view is 0.771 rad wide and 0.5 rad high.
  const Camera camera = cameraAt({0, 0, 0});
  for (const double side : {-1.0, 1.0}) {
    Scene scene;
    const ObjectId beside =
        scene.add(cube(), at(side * 10 * std::sin(0.9), 0, -10 * std::cos(0.9), 0.1, 0.1, 0.1));
    const ObjectId above =
        scene.add(cube(), at(0, side * 10 * std::sin(0.63), -10 * std::cos(0.63), 0.1, 0.1, 0.1));
    const SnapshotPtr snapshot = scene.finish();
    EXPECT_EQ(look(snapshot, camera, {0.0, 0.05}).visible, Ids{});
    EXPECT_EQ(look(snapshot, camera, {0.0, 0.2}).visible, (Ids{beside, above}));
  }
}

TEST(OracleMotion, RollsTheImage) {
  // Above the image's top rim, and within the reach of its corners.
  Scene scene;
  const double up = std::tan(0.5) * 1.2;
  const ObjectId above = scene.add(cube(), at(0, 10 * up, -10, 0.1, 0.1, 0.1));
  EXPECT_EQ(look(scene.finish(), cameraAt({0, 0, 0}), {0.0, 1.5}).visible, Ids{above});
}

TEST(OracleMotion, SeesBesideAWallThroughAnOrthographicCamera) {
  Scene scene;
  const ObjectId front = scene.add(wall(true, true), at(0, 0, -5, 4, 4));
  const ObjectId behind = scene.add(wall(true, true), at(0, 0, -10, 3, 3));
  const SnapshotPtr snapshot = scene.finish();
  glm::dmat4 projection(1.0);
  projection[0][0] = projection[1][1] = 0.25;  // 8 x 8 metres
  projection[2][2] = -2.0 / 99.0;
  projection[3][2] = -101.0 / 99.0;  // near 1, far 100
  const Camera camera = cameraFromMatrices(glm::dmat4(1.0), projection, {80, 80}).value();
  EXPECT_EQ(look(snapshot, camera, {1.0, 0.0}).visible, Ids{front}) << "all rays are parallel";
  EXPECT_EQ(look(snapshot, camera, {0.0, 0.05}).visible, Ids{front}) << "0.25 m aside at most";
  EXPECT_EQ(look(snapshot, camera, {0.0, 0.3}).visible, (Ids{front, behind}));
}

TEST(OracleMotion, SeesAllThatTheStillCameraSeesAndCountsItsPoses) {
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    const SnapshotPtr scene = scenes::randomScene(seed);
    const Camera camera = scenes::toCamera(scenes::randomCameras(seed, *scene, 1)[0]).value();
    const OracleOptions options{.max_samples = 3'000};
    const OracleAnswer still = look(scene, camera, {}, options);
    const OracleAnswer moving = look(scene, camera, {0.1, 0.1}, options);
    EXPECT_EQ(still.poses, 1U);
    EXPECT_EQ(moving.poses, 1U + OracleOptions{}.poses);
    EXPECT_GT(moving.rays, 5 * still.rays);
    EXPECT_TRUE(std::includes(moving.visible.begin(), moving.visible.end(), still.visible.begin(),
                              still.visible.end()));
    EXPECT_TRUE(std::includes(moving.in_frustum.begin(), moving.in_frustum.end(),
                              moving.visible.begin(), moving.visible.end()));
    EXPECT_EQ(moving.unfound_by_poses.tries, moving.poses);
    EXPECT_EQ(still.unfound_by_poses.tries, 0U);
    for (const ObjectId tie : moving.ties) {
      EXPECT_FALSE(std::binary_search(moving.visible.begin(), moving.visible.end(), tie));
    }
  }
}

TEST(OracleMotion, AnswersTheSameWithAnyNumberOfThreads) {
  const SnapshotPtr scene = scenes::randomScene(5);
  const Camera camera = scenes::toCamera(scenes::randomCameras(5, *scene, 1)[0]).value();
  const OracleAnswer one = look(scene, camera, {0.5, 0.2}, {.max_samples = 3'000, .threads = 1});
  const OracleAnswer many = look(scene, camera, {0.5, 0.2}, {.max_samples = 3'000, .threads = 7});
  EXPECT_EQ(one.visible, many.visible);
  EXPECT_EQ(one.pixels, many.pixels);
  EXPECT_EQ(one.ties, many.ties);
  EXPECT_EQ(one.rays, many.rays);
  EXPECT_EQ(one.unfound_by_rays.found_once, many.unfound_by_rays.found_once);
  EXPECT_EQ(one.unfound_by_poses.found_once, many.unfound_by_poses.found_once);
}

/// Rotation that turned the rows of `from` into those of `to`.
double turnBetween(const Camera& from, const Camera& to) {
  const auto frame = [](const Camera& c) {
    return glm::dmat3(glm::dvec3(c.x_row), glm::dvec3(c.y_row), glm::dvec3(c.w_row));
  };
  const glm::dmat3 turn = frame(to) * glm::inverse(frame(from));
  const glm::dvec3 axis(turn[1][2] - turn[2][1], turn[2][0] - turn[0][2], turn[0][1] - turn[1][0]);
  return std::atan2(glm::length(axis), turn[0][0] + turn[1][1] + turn[2][2] - 1.0);
}

TEST(PosesWithin, KeepToTheBoundAndReachIt) {
  for (const MotionBound motion : {MotionBound{1e-3, 1e-4}, MotionBound{20.0, 0.5},
                                   MotionBound{1e6, 9.0}, MotionBound{0.0, 1e-15}}) {
    for (const double where : {0.0, 1e7}) {
      Camera camera = cameraAt({where, -where, where});
      camera.motion = motion;
      double farthest = 0.0, most_turned = 0.0;
      for (const Camera& pose : oracle::posesWithin(camera, 200, 3)) {
        EXPECT_TRUE(pose.motion.still());
        const double moved = glm::length(pose.origin_world - camera.origin_world);
        const double turned = turnBetween(camera, pose);
        EXPECT_LE(moved, motion.radius_m);
        EXPECT_LE(turned, motion.angle_rad + 1e-15);
        farthest = std::max(farthest, moved);
        most_turned = std::max(most_turned, turned);
      }
      EXPECT_GE(farthest, motion.radius_m * (1.0 - 1e-4));
      EXPECT_GE(most_turned, std::min(motion.angle_rad, 3.14159) - 1e-8);
    }
  }
}

TEST(PosesWithin, AreTheCamerasOwnAloneIfItIsStill) {
  const Camera camera = cameraAt({1, 2, 3});
  const auto poses = oracle::posesWithin(camera, 10, 1);
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_EQ(poses[0].origin_world, camera.origin_world);
  EXPECT_EQ(poses[0].x_row, camera.x_row);
}

}  // namespace
}  // namespace culld
