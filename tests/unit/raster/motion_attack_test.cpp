// Sheets and outlines as the rasterizer draws them for a camera in motion: see motion_attack.h.
#include "tests/unit/raster/motion_attack.h"

#include "culling/occluders/convex_pieces.h"
#include "culling/raster/convex_outline.h"
#include "culling/raster/sheet.h"

namespace culld {
namespace {

class CellsInMotion : public MotionAttack {
 protected:
  void draw(const Mesh& mesh, const std::array<double, 12>& world_from_mesh, const CellView& view,
            const glm::dvec3& eye, DepthCells& cells) override {
    const auto [wanted, rows] = placedIn(view, mesh, world_from_mesh, eye);
    const ConvexPieces pieces = ConvexPieces::of(mesh);
    if (pieces.size() == 1 && wanted != 0 && chance(2)) {
      ConvexOutline outline;
      if (outlineOf(pieces[0], rows, view.grid, view.perspective, wanted, outline) ==
          OutlineVerdict::kDraw) {
        drawOutline(outline, 1e30F, cells);
        ++outlines_;
        return;
      }
    }
    std::vector<SheetSurface> surfaces;
    for (const Surface& s : mesh.surfaces) {
      surfaces.push_back({s.first_triangle, s.triangle_count, s.double_sided});
    }
    const glm::dvec3 largest = glm::max(glm::abs(mesh.bounds.min), glm::abs(mesh.bounds.max));
    const Deadline never(steadyClock(), {}, {});
    rasterizer_.draw(
        {mesh.positions, mesh.triangles, mesh.partners, surfaces, world_from_mesh, largest, 1e30F},
        view, eye, never, cells);
  }

  std::size_t outlines_ = 0;
  SheetRasterizer rasterizer_;
};

TEST_F(CellsInMotion, WhatLiesBehindACoveredCellIsHiddenFromEveryPose) {
  attackSeeds(4000);
  std::printf("%zu outlines, %zu cells judged\n", outlines_, cells_);
  EXPECT_GT(cells_, 1500U);
  EXPECT_GT(outlines_, 50U);
}

TEST_F(CellsInMotion, WouldNoticeEdgesThatDoNotSway) {
  forget_motion_ = true;
  attackSeeds(400);
  EXPECT_GT(open_, 100U);
}

TEST(MovingView, AWallNearerThanTheRadiusHidesNothing) {
  Camera camera = cameraFromLookAt({}, {}).value();
  scenes::Triangles wall;
  wall.positions = {{-9, -9, -2}, {9, -9, -2}, {9, 9, -2}, {-9, 9, -2}};
  wall.indices = {0, 1, 2, 0, 2, 3};
  const Mesh mesh = makeMesh({{wall.positions, wall.indices, true, false}});
  const SheetSurface surface{0, 2, false};
  const Deadline never(steadyClock(), {}, {});
  const auto middle = [&](double radius) {
    camera.motion.radius_m = radius;
    const CellView view = cellView(camera, gridFor(camera));
    DepthCells cells;
    cells.reset(view.grid);
    SheetRasterizer().draw({mesh.positions,
                            mesh.triangles,
                            mesh.partners,
                            {&surface, 1},
                            {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                            {9, 9, 2},
                            1e30F},
                           view, {0, 0, 0}, never, cells);
    const CellRect rect{view.grid.width / 2, view.grid.width / 2, view.grid.height / 2,
                        view.grid.height / 2};
    return cells.certainlyHidden(rect, 0.4F);
  };
  EXPECT_TRUE(middle(0.0));
  EXPECT_TRUE(middle(1.85));
  EXPECT_FALSE(middle(1.95));  // the near plane, 0.1 m ahead, could cut it
  EXPECT_FALSE(middle(2.0));
  EXPECT_FALSE(middle(2.1));
}

TEST(MovingView, ExistsAsLongAsOneImageShowsAllPoses) {
  Camera camera = cameraFromLookAt({}, {}).value();
  const auto holds = [&](double radius, double angle) {
    camera.motion = {radius, angle};
    return holdsInMotion(camera);
  };
  EXPECT_TRUE(holds(0.3, 0.0));
  EXPECT_TRUE(holds(1e6, 0.0));
  EXPECT_TRUE(holds(0.3, 0.2));
  EXPECT_FALSE(holds(0.3, 1.2));
  EXPECT_FALSE(holds(0.0, 3.0));
  glm::dmat4 projection(1.0);
  projection[2][2] = -0.01;
  camera = cameraFromMatrices(glm::dmat4(1.0), projection, {}).value();
  EXPECT_TRUE(holds(0.3, 0.0));
  EXPECT_FALSE(holds(0.3, 0.01));
}

}  // namespace
}  // namespace culld
