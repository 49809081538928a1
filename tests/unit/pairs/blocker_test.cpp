#include "culling/pairs/blocker.h"

#include <gtest/gtest.h>

#include "culling/occluders/convex_pieces.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

using scenes::Triangles;

ConvexPieces piecesOf(const Triangles& t) {
  const ConvexPieces pieces = ConvexPieces::of(makeMesh({{t.positions, t.indices, true, false}}));
  EXPECT_EQ(pieces.size(), 1U);
  return pieces;
}

Instance placedAt(const scenes::Rows& rows) {
  Instance instance;
  instance.world_from_mesh = rows;
  return instance;
}

PlaceCorners point(double x, double y, double z) {
  return cornersOf({{{x, y, z}, {x, y, z}}, 0.0});
}
PlaceCorners box(const glm::dvec3& centre, double half) {
  return cornersOf({{centre - half, centre + half}, 0.0});
}

/// From -1 to 1 on each axis.
SolidBlocker cube(const scenes::Rows& rows = scenes::kIdentity) {
  const auto pieces = piecesOf(scenes::box(glm::vec3(-1), glm::vec3(1)));
  return SolidBlocker::of(pieces[0], placedAt(rows)).value();
}

/// From -1 to 1 in x and y at z = 0, front to +z.
FaceBlocker sheet(const scenes::Rows& rows = scenes::kIdentity) {
  const auto pieces = piecesOf(scenes::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}));
  std::vector<FaceBlocker> faces;
  FaceBlocker::append(pieces[0], placedAt(rows), faces);
  EXPECT_EQ(faces.size(), 1U);
  return faces.at(0);
}

TEST(SolidBlocker, HidesWhatLiesWhollyInItsShadow) {
  EXPECT_TRUE(cube().hides(point(0, 0, 5), point(0, 0, -5)));
  EXPECT_TRUE(cube().hides(point(0, 0, 5), box({0, 0, -5}, 0.5)));
  EXPECT_TRUE(cube().hides(box({0, 0, 5}, 0.3), box({0, 0, -5}, 0.5)));
  EXPECT_TRUE(cube().hides(point(0, 0, 5), point(0.5, 0.5, 0))) << "inside it";
}

TEST(SolidBlocker, KeepsWhatReachesOutOfItsShadow) {
  EXPECT_FALSE(cube().hides(point(0, 0, 5), point(3, 0, -5)));
  EXPECT_FALSE(cube().hides(point(0, 0, 5), point(0, 0, 2))) << "in front";
  EXPECT_FALSE(cube().hides(point(0, 0, 5), point(0, 0, 1))) << "on its face";
  EXPECT_FALSE(cube().hides(point(0, 0, 5), box({2.4, 0, -5}, 0.2))) << "the shadow ends at 2.5";
  EXPECT_TRUE(cube().hides(point(0, 0, 5), box({2.2, 0, -5}, 0.2)));
  EXPECT_FALSE(cube().hides(box({0, 0, 5}, 0.3), box({2.2, 0, -5}, 0.2))) << "from beside";
}

TEST(SolidBlocker, HidesNothingFromInside) {
  EXPECT_FALSE(cube().hides(point(0, 0, 0), point(0, 0, -5)));
  EXPECT_FALSE(cube().hides(point(0, 0, 1), point(0, 0, -5))) << "on its face";
  // All corners of the viewer are outside, but not what is between them.
  EXPECT_FALSE(cube().hides(box({0, 0, 0}, 1.5), point(0, 0, -5)));
  EXPECT_FALSE(cube().hides(box({0, 0, 0}, 1.5), point(0, 0, 0)));
}

TEST(SolidBlocker, IsTheSameMirroredAndFarAway) {
  for (const glm::dvec3& scale : {glm::dvec3(-1, 1, 1), glm::dvec3(-1, -1, -1)}) {
    const SolidBlocker mirrored = cube(scenes::scaledAndMoved(scale, {}));
    EXPECT_TRUE(mirrored.hides(point(0, 0, 5), box({0, 0, -5}, 0.5)));
    EXPECT_FALSE(mirrored.hides(point(0, 0, 0), point(0, 0, -5)));
  }
  const double far = 6.4e6;
  const SolidBlocker away = cube(scenes::movedBy(glm::dvec3(far)));
  EXPECT_TRUE(away.hides(point(far, far, far + 5), point(far + 2.4, far, far - 5)));
  EXPECT_FALSE(away.hides(point(far, far, far + 5), point(far + 2.6, far, far - 5)));
}

TEST(SolidBlocker, IsNotMadeOfWhatIsOpenOrFlat) {
  const auto open = piecesOf(scenes::quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}));
  EXPECT_FALSE(SolidBlocker::of(open[0], {}).has_value());
  const auto pieces = piecesOf(scenes::box(glm::vec3(-1), glm::vec3(1)));
  const auto of = [&](const scenes::Rows& rows) {
    return SolidBlocker::of(pieces[0], placedAt(rows)).has_value();
  };
  EXPECT_TRUE(of(scenes::scaledAndMoved({1, 1, 1e-6}, {})));
  EXPECT_FALSE(of(scenes::scaledAndMoved({1, 1, 0}, {})));
  EXPECT_FALSE(of(scenes::scaledAndMoved({1, 1, 1e-12}, {1e6, 1e6, 1e6}))) << "lost in rounding";
  EXPECT_FALSE(of(scenes::scaledAndMoved(glm::dvec3(1e100), {}))) << "products would overflow";
  EXPECT_FALSE(of(scenes::scaledAndMoved(glm::dvec3(1e-100), {}))) << "or be subnormal";
}

TEST(FaceBlocker, HidesFromItsFrontOnly) {
  EXPECT_TRUE(sheet().hides(point(0, 0, 5), point(0, 0, -5)));
  EXPECT_TRUE(sheet().hides(point(0, 0, 5), box({0, 0, -5}, 1.5)));
  EXPECT_TRUE(sheet().hides(box({0, 0, 5}, 0.3), box({0, 0, -5}, 0.5)));
  EXPECT_FALSE(sheet().hides(point(0, 0, -5), point(0, 0, 5))) << "from behind";
  EXPECT_FALSE(sheet().hides(point(0, 0, 0), point(0, 0, -5))) << "on it";
  EXPECT_FALSE(sheet().hides(box({0, 0, 0}, 0.5), point(0, 0, -5))) << "across it";
  EXPECT_FALSE(sheet().hides(point(0, 0, 5), point(0, 0, 0))) << "a target on it";
  EXPECT_FALSE(sheet().hides(point(0, 0, 5), box({0, 0, -5}, 1.9))) << "around its rim";
  EXPECT_FALSE(sheet().hides(point(0, 0, 5), point(3, 0, -5)));
  EXPECT_FALSE(sheet().hides(point(3, 0, 0), point(-3, 0, 0))) << "along it";
}

TEST(FaceBlocker, TurnsOverWithAMirroredNode) {
  const FaceBlocker back = sheet(scenes::scaledAndMoved({1, 1, -1}, {}));
  EXPECT_FALSE(back.hides(point(0, 0, 5), point(0, 0, -5)));
  EXPECT_TRUE(back.hides(point(0, 0, -5), point(0, 0, 5)));
  const FaceBlocker sideways = sheet(scenes::scaledAndMoved({-1, 1, 1}, {}));
  EXPECT_TRUE(sideways.hides(point(0, 0, 5), point(0, 0, -5)));
}

}  // namespace
}  // namespace culld
