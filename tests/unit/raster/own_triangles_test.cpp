// Small objects with known answers: what an object's own triangles may hide, and what they must
// not.
#include "culling/raster/own_triangles.h"

#include <gtest/gtest.h>

#include <numbers>

#include "culling/scene/scene_builder.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

using scenes::Triangles;
using WorldRows = std::array<double, 12>;

constexpr WorldRows kInPlace{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
constexpr std::uint64_t kNoLimit = 1'000'000'000;

/// Upright rectangles in planes of constant z, turned to +z.
Triangles plate(float x0, float y0, float x1, float y1, float z) {
  return scenes::quad({x0, y0, z}, {x1 - x0, 0, 0}, {0, y1 - y0, 0});
}

Mesh meshOf(const Triangles& t, bool blocks = true, bool double_sided = false) {
  return makeMesh({{t.positions, t.indices, blocks, double_sided}});
}

/// The eye stands in the origin and looks down -z; 90 degrees wide and high.
class OwnTrianglesTest : public ::testing::Test {
 protected:
  OwnTrianglesTest() { setCamera({}); }

  void setCamera(LookAt look) {
    look.yfov_rad = std::numbers::pi / 2;
    look.aspect = 1.0;
    camera_ = cameraFromLookAt(look, {512, 512}).value();
    view_ = cellView(camera_, gridFor(camera_));
    cells_.reset(view_.grid);
  }

  static SheetObject object(const Mesh& mesh, const WorldRows& place,
                            std::vector<SheetSurface>& surfaces) {
    surfaces.clear();
    for (const Surface& s : mesh.surfaces) {
      surfaces.push_back({s.first_triangle, s.triangle_count, s.double_sided});
    }
    return {mesh.positions, mesh.triangles,
            mesh.partners,  surfaces,
            place,          glm::max(glm::abs(mesh.bounds.min), glm::abs(mesh.bounds.max)),
            1e30F};
  }

  void draw(const Mesh& mesh, const WorldRows& place = kInPlace) {
    std::vector<SheetSurface> surfaces;
    rasterizer_.draw(object(mesh, place, surfaces), view_, camera_.origin_world, never_, cells_);
  }
  void draw(const Triangles& t) { draw(meshOf(t)); }

  OwnTriangleVerdict ask(const Mesh& mesh, const WorldRows& place = kInPlace,
                         std::uint64_t most_work_ns = kNoLimit) {
    std::vector<SheetSurface> surfaces;
    return ownTrianglesHidden(object(mesh, place, surfaces), view_, camera_.origin_world, never_,
                              most_work_ns, cells_);
  }
  bool hidden(const Mesh& mesh, const WorldRows& place = kInPlace) {
    return ask(mesh, place).hidden;
  }
  bool hidden(const Triangles& t) { return hidden(meshOf(t)); }

  void drawWallOverTheWholeImage() { draw(plate(-50, -50, 50, 50, -10)); }

  const Deadline never_{steadyClock(), {}, {}};
  Camera camera_;
  CellView view_;
  DepthCells cells_;
  SheetRasterizer rasterizer_;
};

TEST_F(OwnTrianglesTest, AnObjectBehindAWallIsHiddenAndBeforeItIsNot) {
  drawWallOverTheWholeImage();
  EXPECT_TRUE(hidden(plate(-3, -3, 3, 3, -11)));
  EXPECT_FALSE(hidden(plate(-3, -3, 3, 3, -9)));
}

TEST_F(OwnTrianglesTest, AnObjectAtTheDepthOfWhatIsDrawnIsNotHidden) {
  drawWallOverTheWholeImage();
  EXPECT_FALSE(hidden(plate(-3, -3, 3, 3, -10)));
}

TEST_F(OwnTrianglesTest, AnObjectSeenThroughAnLShapedGapIsKept) {
  // All but x in [2, 3] above y = -2 and y in [-3, -2] left of x = 3.
  draw(plate(-50, -50, 50, -3, -10));
  draw(plate(-50, -2, 2, 50, -10));
  draw(plate(3, -3, 50, 50, -10));
  EXPECT_FALSE(hidden(plate(-8, -8, 8, 8, -20)));
  EXPECT_FALSE(hidden(plate(5, 5, 5.5F, 8, -20)));  // its left column
  EXPECT_TRUE(hidden(plate(-8, -3, 3, 8, -20)));
}

TEST_F(OwnTrianglesTest, AnObjectIsHiddenThoughItsRectangleSticksOut) {
  // Walls over the left half and the lower half; behind them an L.
  draw(plate(-50, -50, 0, 50, -10));
  draw(plate(-50, -50, 50, 0, -10));
  Triangles l = plate(-8, -8, -6, 8, -20);
  append(l, plate(-6, -8, 8, -6, -20));
  EXPECT_TRUE(hidden(l));
  append(l, plate(7, -6, 8, 1, -20));  // and a foot that reaches above the lower wall
  EXPECT_FALSE(hidden(l));
}

TEST_F(OwnTrianglesTest, WhatTurnsNothingToTheEyeIsHiddenUnlessItIsSeenFromBothSides) {
  Triangles back = plate(-3, -3, 3, 3, -10);
  for (std::size_t i = 0; i < back.indices.size(); i += 3)
    std::swap(back.indices[i], back.indices[i + 1]);
  EXPECT_TRUE(hidden(back));
  EXPECT_FALSE(hidden(meshOf(back, true, true)));
  // A mirrored node turns its front like its shape: to the other side along the axis mirrored.
  constexpr WorldRows kMirroredX{-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  constexpr WorldRows kMirroredZ{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, -20};
  EXPECT_TRUE(hidden(meshOf(back), kMirroredX));
  EXPECT_FALSE(hidden(meshOf(back), kMirroredZ));
  EXPECT_TRUE(hidden(meshOf(plate(-3, -3, 3, 3, -10)), kMirroredZ));
}

TEST_F(OwnTrianglesTest, ASliverSeenEdgeOnIsKeptWhereNothingHidesIt) {
  // Both lie in planes through the eye: which side they turn to it hangs on rounding.
  const Triangles edge_on = scenes::quad({1, -3, -5}, {2, 0, -10}, {0, 6, 0});
  EXPECT_FALSE(hidden(edge_on));
  EXPECT_FALSE(hidden(scenes::quad({0.3F, -3, -1}, {0.6F, 0, -2}, {0, 6, 0})));
  drawWallOverTheWholeImage();
  EXPECT_FALSE(hidden(edge_on));
  EXPECT_TRUE(hidden(scenes::quad({3, -3, -15}, {2, 0, -10}, {0, 6, 0})));
}

TEST_F(OwnTrianglesTest, AFlatObjectHasNoKnownFront) {
  constexpr WorldRows kFlat{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, -10};
  EXPECT_FALSE(hidden(meshOf(plate(-3, -3, 3, 3, 1)), kFlat));
  Triangles back = plate(-3, -3, 3, 3, 1);
  std::swap(back.indices[0], back.indices[1]);
  EXPECT_FALSE(hidden(meshOf(back), kFlat));
}

TEST_F(OwnTrianglesTest, AFloorUnderTheEyeIsKeptForWhatLiesBeforeTheWall) {
  const Triangles floor = scenes::quad({-20, -1, 20}, {40, 0, 0}, {0, 0, -60});
  drawWallOverTheWholeImage();
  EXPECT_FALSE(hidden(floor));
  draw(plate(-1, -1, 1, 1, -0.2F));  // nearer than any of the floor that is on the image
  EXPECT_TRUE(hidden(floor));
}

TEST_F(OwnTrianglesTest, AWallThatPassesTheEyeBesideTheImageIsHidden) {
  // It crosses the near plane's plane, and its rectangle is the whole image.
  const Triangles beside = scenes::quad({5, -5, -4}, {0, 0, 14}, {0, 10, 0});
  EXPECT_TRUE(hidden(meshOf(beside, true, true)));
  const Triangles reaching = scenes::quad({5, -5, -5.5F}, {0, 0, 14}, {0, 10, 0});
  EXPECT_FALSE(hidden(meshOf(reaching, true, true)));
}

TEST_F(OwnTrianglesTest, AroundTheEyeOnlyWhatIsDrawnNearerHides) {
  const Mesh room = meshOf(scenes::box({-30, -30, -30}, {30, 30, 30}), true, true);
  EXPECT_FALSE(hidden(room));
  drawWallOverTheWholeImage();
  EXPECT_TRUE(hidden(room));
}

TEST_F(OwnTrianglesTest, WhatLiesBeyondTheClipPlanesIsNotSeen) {
  LookAt look;
  look.znear_m = 2.0;
  look.zfar_m = 30.0;
  setCamera(look);
  EXPECT_TRUE(hidden(plate(-1, -1, 1, 1, -1.9F)));
  EXPECT_TRUE(hidden(plate(-1, -1, 1, 1, -31)));
  EXPECT_FALSE(hidden(plate(-1, -1, 1, 1, -2.1F)));
  EXPECT_FALSE(hidden(plate(-1, -1, 1, 1, -29)));
  // From before the near plane to behind the far plane.
  EXPECT_FALSE(hidden(scenes::quad({-1, -1, -1}, {2, 0, 0}, {0, 0, -40})));
}

TEST_F(OwnTrianglesTest, BlendedSurfacesAreSeen) {
  EXPECT_FALSE(hidden(meshOf(plate(-3, -3, 3, 3, -20), false)));
  drawWallOverTheWholeImage();
  EXPECT_TRUE(hidden(meshOf(plate(-3, -3, 3, 3, -20), false)));
  EXPECT_FALSE(hidden(meshOf(plate(-3, -3, 3, 3, -5), false)));
}

TEST_F(OwnTrianglesTest, NoObjectHidesItself) {
  scenes::Random random(5);
  for (int i = 0; i < 20; ++i) {
    cells_.reset(view_.grid);
    const Mesh mesh =
        meshOf(i % 2 == 0 ? scenes::ball(6, 0.4, random) : scenes::torus(9, 5, 0.8F, 0.25F));
    const double size = 1.0 + i;
    const WorldRows place{size, 0, 0.1, 2, 0, size, 0.3, -1, 0.2, 0, size, -4.0 * size};
    draw(mesh, place);
    EXPECT_FALSE(hidden(mesh, place));
    const WorldRows behind{size, 0, 0.1, 4, 0, size, 0.3, -2, 0.2, 0, size, -8.0 * size};
    draw(mesh, behind);
    EXPECT_FALSE(hidden(mesh, place));
  }
}

TEST_F(OwnTrianglesTest, WhatCannotBeDecidedIsKept) {
  drawWallOverTheWholeImage();
  const Mesh plain = meshOf(plate(-3, -3, 3, 3, -20));
  for (const double bad : {std::nan(""), 1e300, HUGE_VAL, -HUGE_VAL}) {
    WorldRows place = kInPlace;
    place[0] = bad;
    EXPECT_FALSE(hidden(plain, place)) << bad;
  }
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    WorldRows place = kInPlace;
    place[11] = bad;
    EXPECT_FALSE(hidden(plain, place)) << bad;
  }
}

TEST_F(OwnTrianglesTest, AnObjectIsKeptWhenItsWorkOrTheTimeIsUsedUp) {
  drawWallOverTheWholeImage();
  scenes::Random random(5);
  Triangles far;
  append(far, scenes::ball(40, 0.3, random), {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, -20});
  const Mesh mesh = meshOf(far);
  const OwnTriangleVerdict whole = ask(mesh);
  EXPECT_TRUE(whole.hidden);
  const OwnTriangleVerdict cut = ask(mesh, kInPlace, whole.work_ns / 2);
  EXPECT_FALSE(cut.hidden);
  EXPECT_FALSE(cut.out_of_time);
  EXPECT_LT(cut.work_ns, whole.work_ns);

  struct Late final : Clock {
    std::chrono::nanoseconds now() const noexcept override { return std::chrono::hours(1); }
  } late;
  std::vector<SheetSurface> surfaces;
  const Deadline passed(late, {}, std::chrono::nanoseconds(1));
  const OwnTriangleVerdict late_verdict = ownTrianglesHidden(
      object(mesh, kInPlace, surfaces), view_, camera_.origin_world, passed, kNoLimit, cells_);
  EXPECT_FALSE(late_verdict.hidden);
  EXPECT_TRUE(late_verdict.out_of_time);
}

}  // namespace
}  // namespace culld
