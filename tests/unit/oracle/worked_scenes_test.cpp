// Scenes whose visible objects follow from a line of arithmetic, at every scale and place.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/mat4x4.hpp>
#include <glm/vec2.hpp>

#include "culling/oracle/oracle.h"
#include "tests/unit/oracle/small_scenes.h"

namespace culld {
namespace {

using oracle_test::at;
using oracle_test::cameraAt;
using oracle_test::cube;
using oracle_test::Rows;
using oracle_test::Scene;
using oracle_test::wall;
using Ids = std::vector<ObjectId>;

Ids visible(Scene& scene, const Camera& camera) {
  const auto oracle = Oracle::build(scene.finish());
  EXPECT_TRUE(oracle.ok());
  return oracle.value()->look(camera, {.rays_per_object = 64}).value().visible;
}

/// Where a worked scene stands, and how large a metre of it is.
struct Place {
  double offset_m, scale;
};

class WorkedScenes : public testing::TestWithParam<Place> {
 protected:
  Rows placed(double x, double y, double z, double sx, double sy, double sz) const {
    const auto [offset, s] = GetParam();
    return at(offset + s * x, offset + s * y, offset + s * z, s * sx, s * sy, s * sz);
  }
  Camera eye() const {
    const auto [offset, s] = GetParam();
    return cameraAt({offset, offset, offset}, {160, 90}, 0.1 * s);
  }
  /// 8 x 8 metres, from 1 to 100 m.
  Camera orthographic() const {
    const auto [offset, s] = GetParam();
    glm::dmat4 view(1.0), projection(1.0);
    view[3] = {-offset, -offset, -offset, 1.0};
    projection[0][0] = projection[1][1] = 0.25 / s;
    projection[2][2] = -2.0 / (99.0 * s);
    projection[3][2] = -101.0 / 99.0;
    return cameraFromMatrices(view, projection, {80, 80}).value();
  }
  /// A slit 0.1 wide at 5, and a row of 11 posts 0.1 wide, 0.15 apart, at 20.
  Ids slitAndPosts(Scene& scene) {
    Ids walls{scene.add(wall(true, true), placed(-50.05, 0, -5, 100, 100, 1)),
              scene.add(wall(true, true), placed(50.05, 0, -5, 100, 100, 1))};
    for (int k = -5; k <= 5; ++k) {
      posts_.push_back(scene.add(wall(true, true), placed(0.15 * k, 0, -20, 0.1, 1, 1)));
    }
    return walls;
  }
  ObjectId post(int k) const { return posts_[static_cast<std::size_t>(k + 5)]; }

 private:
  Ids posts_;
};

TEST_P(WorkedScenes, ASlitShowsWhatItsShadowLeaves) {
  // At 20 the slit opens 0.4: posts within 0.2 of the middle, that is -1, 0 and 1.
  Scene scene;
  Ids expected = slitAndPosts(scene);
  for (const int k : {-1, 0, 1}) expected.push_back(post(k));
  EXPECT_EQ(visible(scene, eye()), expected);
}

TEST_P(WorkedScenes, ASlitShowsNoMoreThanItsWidthToParallelRays) {
  Scene scene;
  Ids expected = slitAndPosts(scene);
  expected.push_back(post(0));
  EXPECT_EQ(visible(scene, orthographic()), expected);
}

TEST_P(WorkedScenes, AShearedWallHidesWhatItsParallelogramCovers) {
  // At 5 it spans y in [-2, 2] and x in [-2 + y / 2, 2 + y / 2]; the specks are at 10.
  const auto [offset, s] = GetParam();
  for (const double mirror : {1.0, -1.0}) {
    Scene scene;
    Ids expected{scene.add(
        wall(), {mirror * 4 * s, 2 * s, 0, offset, 0, 4 * s, 0, offset, 0, 0, s, offset - 5 * s})};
    for (const double y : {-1.6, 1.6}) {
      for (const double beside : {-2.4, -1.8, 1.8, 2.4}) {
        const double x = y / 2 + beside;
        const ObjectId speck = scene.add(wall(true, true), placed(2 * x, 2 * y, -10, 0.1, 0.1, 1));
        if (std::abs(beside) > 2) expected.push_back(speck);
      }
    }
    EXPECT_EQ(visible(scene, eye()), expected);
  }
}

TEST_P(WorkedScenes, GlassAndLeavesShowAllThatIsBehindThem) {
  Scene scene;
  Ids expected;
  for (int i = 0; i < 5; ++i) {
    expected.push_back(scene.add(wall(false, i % 2 != 0), placed(0, 0, -2 - i, 40, 40, 1)));
  }
  expected.push_back(scene.add(wall(), placed(0, 0, -8, 40, 40, 1)));
  scene.add(wall(), placed(0, 0, -9, 1, 1, 1));
  EXPECT_EQ(visible(scene, eye()), expected);
}

TEST_P(WorkedScenes, OneMeshMayBlockInPart) {
  // The left half is glass, the right half is not.
  Scene scene;
  RawSurface glass = wall(false), brick = wall();
  for (glm::vec3& p : glass.positions) p.x -= 0.5F;
  for (glm::vec3& p : brick.positions) p.x += 0.5F;
  const ObjectId screen = scene.add(std::vector{glass, brick}, placed(0, 0, -5, 10, 10, 1));
  const ObjectId left = scene.add(cube(), placed(-3, 0, -10, 1, 1, 1));
  scene.add(cube(), placed(3, 0, -10, 1, 1, 1));
  EXPECT_EQ(visible(scene, eye()), (Ids{screen, left}));
}

INSTANTIATE_TEST_SUITE_P(Places, WorkedScenes,
                         testing::Values(Place{0.0, 1.0}, Place{1e7, 0.01}, Place{-6.4e6, 1.0},
                                         Place{0.0, 1e-9}, Place{0.0, 1e9}));

TEST(WorkedScene, ReachesFromACentimetreToTheStars) {
  Scene scene;
  const ObjectId finger = scene.add(wall(), at(-0.05, 0, -0.01, 0.1, 0.1));  // the left half
  scene.add(cube(), at(-2e10, 0, -1e11, 1e9, 1e9, 1e9));
  const ObjectId star = scene.add(cube(), at(2e10, 0, -1e11, 1e9, 1e9, 1e9));
  EXPECT_EQ(visible(scene, cameraAt({0, 0, 0}, {160, 90}, 1e-3)), (Ids{finger, star}));
}

/// Maps everything onto a plane, up to rounding: the third column is a sum of the others.
Rows flatUpToRounding(double turn) {
  Rows rows = at(0, 0, -5);
  const double c = 4 * std::cos(turn), s = 4 * std::sin(turn);
  rows[0] = c, rows[1] = -s, rows[4] = s, rows[5] = c;
  rows[8] = 0.1, rows[9] = 0.3;
  for (std::size_t r = 0; r < 3; ++r) rows[4 * r + 2] = 0.7 * rows[4 * r] - 0.3 * rows[4 * r + 1];
  return rows;
}

TEST(WorkedScene, CallsNothingVisibleBecauseOfARoundedDeterminant) {
  for (int i = 0; i < 20; ++i) {
    SCOPED_TRACE(i);
    Scene scene;
    scene.add(cube(), flatUpToRounding(0.3 + 0.1 * i));
    scene.add(cube(), at(0, 0, -10));  // hidden if that one shows its front
    EXPECT_EQ(visible(scene, cameraAt({0, 0, 0})), Ids{});
  }
}

TEST(WorkedScene, SeesAndIsBlockedByBothSidesOfWhatIsFlatUpToRounding) {
  RawSurface both = cube();
  both.double_sided = true;
  Scene scene;
  const ObjectId flat = scene.add(both, flatUpToRounding(0.3));
  scene.add(cube(), at(0, 0, -10));
  EXPECT_EQ(visible(scene, cameraAt({0, 0, 0})), Ids{flat});
}

}  // namespace
}  // namespace culld
