// Scenes with known answers: what must be seen, what must not.
#include "culling/oracle/oracle.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/mat4x4.hpp>
#include <limits>

#include "culling/scene/edit.h"
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

OracleAnswer look(const SnapshotPtr& scene, const Camera& camera, OracleOptions options = {}) {
  auto oracle = Oracle::build(scene);
  EXPECT_TRUE(oracle.ok());
  auto answer = oracle.value()->look(camera, options);
  EXPECT_TRUE(answer.ok());
  return std::move(answer).value();
}

Ids visible(Scene& scene, const Camera& camera) { return look(scene.finish(), camera).visible; }

const Camera kCamera = cameraAt({0, 0, 0});

TEST(Oracle, SeesTheFrontObjectAndNotTheOneBehindIt) {
  Scene scene;
  const ObjectId front = scene.add(cube(), at(0, 0, -5, 4, 4, 1));
  scene.add(cube(), at(0, 0, -10));
  EXPECT_EQ(visible(scene, kCamera), Ids{front});
}

TEST(Oracle, SeesNothingInAnEmptyScene) {
  Scene scene;
  const OracleAnswer answer = look(scene.finish(), kCamera);
  EXPECT_TRUE(answer.visible.empty());
  EXPECT_TRUE(answer.in_frustum.empty());
}

TEST(Oracle, DoesNotSeeWhatIsOutsideOfTheFrustum) {
  Scene scene;
  scene.add(cube(), at(0, 0, 5));
  scene.add(cube(), at(100, 0, -5));
  const ObjectId inside = scene.add(cube(), at(0, 0, -5));
  EXPECT_EQ(visible(scene, kCamera), Ids{inside});
}

TEST(Oracle, LetsNothingBlockThatIsNearerThanTheNearPlane) {
  Scene scene;
  scene.add(wall(true, true), at(0, 0, -1, 100, 100));
  const ObjectId behind = scene.add(cube(), at(0, 0, -10));
  EXPECT_EQ(visible(scene, cameraAt({0, 0, 0}, {160, 90}, 2.0)), Ids{behind});
}

TEST(Oracle, SeesThroughNonBlockingSurfacesAndSeesThem) {
  Scene scene;
  const ObjectId glass = scene.add(wall(false), at(0, 0, -5, 100, 100));
  const ObjectId behind = scene.add(cube(), at(0, 0, -10));
  EXPECT_EQ(visible(scene, kCamera), (Ids{glass, behind}));
}

TEST(Oracle, NeitherSeesNorIsBlockedByTheBackOfASingleSidedTriangle) {
  Scene scene;
  scene.add(wall(), at(0, 0, -5, -100, 100, -1));  // turned by half a turn: its back to the eye
  const ObjectId behind = scene.add(cube(), at(0, 0, -10));
  EXPECT_EQ(visible(scene, kCamera), Ids{behind});
}

TEST(Oracle, SeesDoubleSidedTrianglesFromBothSides) {
  Scene scene;
  const ObjectId turned = scene.add(wall(true, true), at(0, 0, -5, -100, 100, -1));
  scene.add(cube(), at(0, 0, -10));
  EXPECT_EQ(visible(scene, kCamera), Ids{turned});
}

TEST(Oracle, KeepsFrontsInFrontWhenAnInstanceIsMirrored) {
  Scene scene;
  const ObjectId mirrored = scene.add(wall(), at(0, 0, -5, -100, 100, 1));
  scene.add(cube(), at(0, 0, -10));
  EXPECT_EQ(visible(scene, kCamera), Ids{mirrored});
}

TEST(Oracle, KeepsFrontsInFrontWhenTheViewIsMirrored) {
  Scene scene;
  const ObjectId front = scene.add(wall(), at(0, 0, -5, 100, 100));
  scene.add(wall(), at(0, 0, -3, -100, 100, -1));
  glm::dmat4 mirror(1.0), projection(0.0);
  mirror[0][0] = -1.0;
  projection[0][0] = projection[1][1] = 1.0;
  projection[2][2] = projection[2][3] = -1.0;
  projection[3][2] = -0.2;
  const auto camera = cameraFromMatrices(mirror, projection, {160, 90});
  ASSERT_TRUE(camera.ok());
  EXPECT_EQ(visible(scene, camera.value()), Ids{front});
}

TEST(Oracle, LeavesOutHiddenAndRemovedObjectsAndWhatTheyHid) {
  Scene scene;
  const ObjectId first = scene.add(cube(), at(0, 0, -5, 9, 9, 1));
  const ObjectId second = scene.add(cube(), at(0, 0, -10, 19, 19, 1));
  const ObjectId third = scene.add(cube(), at(0, 0, -20));
  const std::vector<Edit> edits{HideObject{first}, RemoveObject{second}};
  const auto edited = applyEdits(scene.finish(), edits);
  ASSERT_TRUE(edited.ok());
  EXPECT_EQ(look(edited.value().snapshot, kCamera).visible, Ids{third});
}

TEST(Oracle, NeverLetsAnObjectBlockThatIsAlwaysKept) {
  RawSurface broken = wall();
  broken.positions.emplace_back(std::numeric_limits<float>::quiet_NaN(), 0.0F, 0.0F);
  broken.indices.insert(broken.indices.end(), {0, 1, 4});
  Scene scene;
  const ObjectId kept = scene.add(broken, at(0, 0, -5, 100, 100));
  const ObjectId behind = scene.add(cube(), at(0, 0, -10));
  const SnapshotPtr snapshot = scene.finish();
  ASSERT_TRUE(snapshot->instance(kept).always_kept);
  EXPECT_EQ(look(snapshot, kCamera).visible, (Ids{kept, behind}));
}

TEST(Oracle, SeesThroughAHoleMuchSmallerThanAPixel) {
  RawSurface sheet;  // [-1,1]^2 with a hole of side 2e-4 around (0.3, 0.2)
  const float low_x = 0.2999F, high_x = 0.3001F, low_y = 0.1999F, high_y = 0.2001F;
  sheet.positions = {{-1, -1, 0},         {1, -1, 0},        {1, 1, 0},
                     {-1, 1, 0},          {low_x, low_y, 0}, {high_x, low_y, 0},
                     {high_x, high_y, 0}, {low_x, high_y, 0}};
  sheet.indices = {0, 1, 5, 0, 5, 4, 1, 2, 6, 1, 6, 5, 2, 3, 7, 2, 7, 6, 3, 0, 4, 3, 4, 7};
  Scene scene;
  scene.add(sheet, at(0, 0, -4, 10, 10));
  const ObjectId seen = scene.add(wall(), at(0.3 * 20, 0.2 * 20, -8, 1e-3, 1e-3));
  const LookAt aside{{0, 0, 0}, {6, 4, -8}, {0, 1, 0}, 1.0, 16.0 / 9.0, 0.1, {}};
  const auto towards = cameraFromLookAt(aside, {16, 9});
  ASSERT_TRUE(towards.ok());
  const OracleAnswer answer = look(scene.finish(), towards.value());
  ASSERT_EQ(answer.visible.size(), 2U);
  EXPECT_EQ(answer.visible[1], seen);
  EXPECT_EQ(answer.subpixel[1], 1);
  EXPECT_EQ(answer.subpixel[0], 0);
}

TEST(Oracle, SeesACentimetreAtTheSurfaceOfAPlanet) {
  const double earth = 6.4e6;
  Scene scene;
  const ObjectId coin = scene.add(cube(), at(earth, earth, earth - 5, 0.01, 0.01, 0.01));
  scene.add(cube(), at(earth, earth, earth - 5.02, 0.009, 0.009, 0.009));
  const ObjectId beside =
      scene.add(cube(), at(earth + 0.0101, earth, earth - 5.02, 0.01, 0.01, 0.01));
  const Camera camera = cameraAt({earth, earth, earth}, {1920, 1080});
  EXPECT_EQ(visible(scene, camera), (Ids{coin, beside}));
}

TEST(Oracle, SeesBothOfTwoCoplanarWalls) {
  Scene scene;
  const ObjectId one = scene.add(wall(), at(0, 0, -5, 3, 3));
  const ObjectId other = scene.add(wall(), at(0, 0, -5, 4, 4));
  EXPECT_EQ(visible(scene, kCamera), (Ids{one, other}));
}

TEST(Oracle, ListsSurfacesBehindByLessThanTheToleranceAsTies) {
  Scene scene;
  const ObjectId front = scene.add(wall(), at(0, 0, -5, 4, 4));
  const ObjectId tie = scene.add(wall(), at(0, 0, -5.00001, 3, 3));
  scene.add(wall(), at(0, 0, -5.001, 3, 3));
  const OracleAnswer answer = look(scene.finish(), kCamera);
  EXPECT_EQ(answer.visible, Ids{front});
  EXPECT_EQ(answer.ties, Ids{tie});
}

TEST(Oracle, DoesNotSeeThroughTheCrackOfATJunction) {
  // The left wall has one long edge, the right one the same edge in two; the vertex between is
  // rounded to float and so does not lie on the long edge. A speck hangs exactly behind the crack.
  const glm::vec3 low(0.1F, -1, 0), high(0.3F, 1, 0);
  const RawSurface left{{{-1, -1, 0}, low, high, {-1, 1, 0}}, {0, 1, 2, 0, 2, 3}, true, false};
  std::size_t cracks = 0;
  for (int split = 1; split < 20; ++split) {
    const glm::vec3 between = low + (high - low) * (static_cast<float>(split) / 20.0F);
    const glm::dvec3 crack = (glm::dvec3(low) + glm::dvec3(high) + glm::dvec3(between)) / 3.0;
    const double edge_x = low.x + (crack.y - low.y) * (double{high.x} - low.x) / 2.0;
    if (crack.x > edge_x) ++cracks;  // else the walls overlap
    Scene scene;
    const ObjectId a = scene.add(left, at(0, 0, -5, 10, 10));
    const RawSurface right{
        {low, {1, -1, 0}, {1, 1, 0}, high, between}, {0, 1, 4, 4, 1, 2, 4, 2, 3}, true, false};
    const ObjectId b = scene.add(right, at(0, 0, -5, 10, 10));
    scene.add(wall(), at(crack.x * 20, crack.y * 20, -10, 1e-10, 1e-10));
    EXPECT_EQ(visible(scene, kCamera), (Ids{a, b})) << "split " << split;
  }
  EXPECT_GT(cracks, 3U);
}

TEST(Oracle, CountsThePixelsOfAnObject) {
  Scene scene;
  scene.add(wall(), at(-50, 0, -5, 100, 100));  // the left half of the image
  const OracleAnswer answer = look(scene.finish(), kCamera);
  ASSERT_EQ(answer.pixels.size(), 1U);
  EXPECT_NEAR(answer.pixels[0], 160 * 90 / 2.0, 20);
}

TEST(Oracle, CountsThePixelsOfAHugeImageWithAThinnerLattice) {
  Scene scene;
  scene.add(wall(), at(-50, 0, -5, 100, 100));
  const Camera camera = cameraAt({0, 0, 0}, {16384, 9216});
  const OracleAnswer answer = look(scene.finish(), camera, {.max_samples = 100'000});
  ASSERT_EQ(answer.pixels.size(), 1U);
  EXPECT_NEAR(answer.pixels[0] / (16384.0 * 9216.0), 0.5, 0.01);
  EXPECT_LE(answer.rays, 100'000U);
}

TEST(Oracle, AnswersTheSameWithAnyNumberOfThreads) {
  Scene scene;
  for (int i = 0; i < 400; ++i) {
    scene.add(cube(), at(std::sin(i * 7.0) * 20, std::cos(i * 3.0) * 10, -5 - i * 0.2));
  }
  const SnapshotPtr snapshot = scene.finish();
  const OracleAnswer one = look(snapshot, kCamera, {.threads = 1});
  for (const std::size_t threads : {2U, 7U}) {
    const OracleAnswer many = look(snapshot, kCamera, {.threads = threads});
    EXPECT_EQ(one.visible, many.visible);
    EXPECT_EQ(one.pixels, many.pixels);
    EXPECT_EQ(one.subpixel, many.subpixel);
    EXPECT_EQ(one.ties, many.ties);
    EXPECT_EQ(one.rays, many.rays);
  }
  EXPECT_GT(one.visible.size(), 50U);
  EXPECT_LT(one.visible.size(), 400U);
}

TEST(Oracle, SeesFlattenedInstances) {
  Scene scene;
  const ObjectId flat = scene.add(cube(), at(0, 0, -5, 3, 3, 0));
  scene.add(cube(), at(0, 0, -10));
  scene.add(cube(), at(1, 0, -4, 0, 0, 0));
  EXPECT_EQ(visible(scene, kCamera), Ids{flat});
}

TEST(Oracle, LooksThroughOrthographicCameras) {
  Scene scene;
  const ObjectId front = scene.add(cube(), at(0, 0, -5));
  scene.add(cube(), at(0, 0, -50, 0.9, 0.9, 0.9));
  const ObjectId beside = scene.add(cube(), at(2, 0, -50));
  scene.add(cube(), at(0, 0, -150));  // beyond the far plane
  scene.add(cube(), at(20, 0, -50));  // to the right of it
  glm::dmat4 projection(1.0);
  projection[0][0] = projection[1][1] = 0.25;  // 8 x 8 metres
  projection[2][2] = -2.0 / 99.0;
  projection[3][2] = -101.0 / 99.0;  // near 1, far 100
  const auto camera = cameraFromMatrices(glm::dmat4(1.0), projection, {80, 80});
  ASSERT_TRUE(camera.ok());
  const OracleAnswer answer = look(scene.finish(), camera.value());
  ASSERT_EQ(answer.visible, (Ids{front, beside}));
  EXPECT_NEAR(answer.pixels[0], 100, 5);
}

TEST(Oracle, LooksThroughOffCentreCamerasWithAFarPlane) {
  Scene scene;
  scene.add(cube(), at(-3, 0, -5));
  const ObjectId right = scene.add(cube(), at(3, 0, -5));
  scene.add(cube(), at(30, 0, -60));
  glm::dmat4 projection(0.0);  // left 0, right 1, bottom -0.5, top 0.5, near 1, far 50
  projection[0][0] = projection[1][1] = 2.0;
  projection[2][0] = 1.0;
  projection[2][2] = -51.0 / 49.0;
  projection[2][3] = -1.0;
  projection[3][2] = -100.0 / 49.0;
  const auto camera = cameraFromMatrices(glm::dmat4(1.0), projection, {80, 80});
  ASSERT_TRUE(camera.ok());
  EXPECT_EQ(visible(scene, camera.value()), Ids{right});
}

TEST(Oracle, PaintsObjectDistanceAndNormalTopRowFirst) {
  Scene scene;
  const ObjectId top = scene.add(wall(), at(0, 50, -5, 200, 100));
  auto oracle = Oracle::build(scene.finish());
  ASSERT_TRUE(oracle.ok());
  const auto picture = oracle.value()->paint(kCamera);
  ASSERT_TRUE(picture.ok());
  const auto& pixels = picture.value();
  ASSERT_EQ(pixels.size(), 160U * 90U);
  EXPECT_EQ(pixels[80 + 160 * 10].object, top);
  EXPECT_EQ(pixels[80 + 160 * 80].object, kNoObject);
  EXPECT_NEAR(pixels[80 + 160 * 44].distance_m, 5.0F, 0.01F);
  EXPECT_NEAR(pixels[80 + 160 * 44].normal_world.z, 1.0F, 1e-6F);
}

}  // namespace
}  // namespace culld
