// Small sheets with known answers: what a wall hides, and what its holes, rims and backs must not.
#include "culling/raster/sheet.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <tuple>

namespace culld {
namespace {

/// A mesh made by hand; edges are paired by equal positions.
struct HandMesh {
  std::vector<glm::vec3> positions;
  std::vector<std::array<std::uint32_t, 3>> triangles;

  std::uint32_t corner(const glm::vec3& p) {
    for (std::size_t i = 0; i < positions.size(); ++i) {
      if (positions[i] == p) return static_cast<std::uint32_t>(i);
    }
    positions.push_back(p);
    return static_cast<std::uint32_t>(positions.size() - 1);
  }
  void triangle(const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
    triangles.push_back({corner(a), corner(b), corner(c)});
  }
  /// Two triangles in the plane z, CCW seen from +z.
  void quad(float x0, float y0, float x1, float y1, float z) {
    triangle({x0, y0, z}, {x1, y0, z}, {x1, y1, z});
    triangle({x0, y0, z}, {x1, y1, z}, {x0, y1, z});
  }
  std::vector<std::uint32_t> partners() const {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> edges;
    std::vector<std::uint32_t> out(3 * triangles.size(), 0xFFFFFFFFU);
    for (std::uint32_t t = 0; t < triangles.size(); ++t) {
      for (std::uint32_t e = 0; e < 3; ++e)
        edges[{triangles[t][e], triangles[t][(e + 1) % 3]}] = 3 * t + e;
    }
    for (const auto& [edge, half] : edges) {
      const auto other = edges.find({edge.second, edge.first});
      if (other != edges.end()) out[half] = other->second;
    }
    return out;
  }
};

class SheetTest : public ::testing::Test {
 protected:
  SheetTest() { setCamera(LookAt{}); }

  void setCamera(const LookAt& look) {
    camera_ = cameraFromLookAt(look, {640, 360}).value();
    view_ = cellView(camera_, gridFor(camera_));
    cells_.reset(view_.grid);
  }

  DrawnSheet draw(const HandMesh& mesh, bool double_sided = false, bool mirrored = false,
                  double thickness = 1.0, std::chrono::nanoseconds time_limit = {}) {
    const std::vector<std::uint32_t> partners = mesh.partners();
    const SheetSurface surface{0, static_cast<std::uint32_t>(mesh.triangles.size()), double_sided};
    std::array<double, 12> world{1, 0, 0, 0, 0,         1,
                                 0, 0, 0, 0, thickness, -10.0 * (1.0 - thickness)};
    if (mirrored) world[0] = -1.0;
    const Deadline deadline(steadyClock(), {}, time_limit);
    return rasterizer_.draw({mesh.positions,
                             mesh.triangles,
                             partners,
                             {&surface, 1},
                             world,
                             glm::dvec3(1e4),

                             1e30F},
                            view_, camera_.origin_world, deadline, cells_);
  }

  std::uint64_t coveredCells() {
    std::uint64_t covered = 0;
    for (std::uint32_t y = 0; y < view_.grid.height; ++y) {
      for (std::uint32_t x = 0; x < view_.grid.width; ++x) covered += cellAt(x, y) > 0.0F;
    }
    return covered;
  }
  float cellAt(std::uint32_t x, std::uint32_t y) {
    const std::uint32_t block = view_.grid.blockAt(x / 8, y / 8);
    return std::max(cells_.cells(block)[y % 8 * 8 + x % 8], cells_.leastNearness(block));
  }
  std::uint64_t allCells() const { return std::uint64_t{view_.grid.width} * view_.grid.height; }

  Camera camera_;
  CellView view_;
  DepthCells cells_;
  SheetRasterizer rasterizer_;
};

TEST_F(SheetTest, AWallOfTwoTrianglesCoversEveryCellAtItsDistance) {
  HandMesh wall;
  wall.quad(-50, -50, 50, 50, -10);
  draw(wall);
  EXPECT_EQ(coveredCells(), allCells());
  EXPECT_NEAR(cellAt(320, 180), 0.1, 1e-6);
  EXPECT_LE(cellAt(320, 180), 0.1F);
  EXPECT_TRUE(cells_.certainlyHidden({0, view_.grid.width - 1, 0, view_.grid.height - 1}, 0.09F));
}

TEST_F(SheetTest, AFinelyTessellatedWallLosesNoCellInside) {
  HandMesh wall;
  for (int y = -30; y < 30; ++y) {
    for (int x = -30; x < 30; ++x) {
      wall.quad(static_cast<float>(x) * 0.7F, static_cast<float>(y) * 0.7F,
                static_cast<float>(x + 1) * 0.7F, static_cast<float>(y + 1) * 0.7F, -10.0F);
    }
  }
  draw(wall);
  EXPECT_EQ(coveredCells(), allCells());
}

TEST_F(SheetTest, AWallSeenFromBehindCoversNothingUnlessItIsDoubleSided) {
  HandMesh wall;
  wall.triangle({-50, -50, -10}, {-50, 50, -10}, {50, 50, -10});
  draw(wall);
  EXPECT_EQ(coveredCells(), 0U);
  draw(wall, true);
  EXPECT_GT(coveredCells(), 0U);
}

TEST_F(SheetTest, AMirroredWallTurnsItsOtherSide) {
  HandMesh wall;
  wall.quad(-50, -50, 50, 50, -10);
  draw(wall, false, true);  // the mirror itself reverses the winding: still its front
  EXPECT_EQ(coveredCells(), allCells());
}

TEST_F(SheetTest, AnObjectFlattenedBeyondTellingItsFrontCoversNothing) {
  HandMesh wall;
  wall.quad(-50, -50, 50, 50, -10);
  draw(wall, true, false, 0.0);
  EXPECT_EQ(coveredCells(), 0U);
}

TEST_F(SheetTest, ASheetCutShortProvesOnlyWhatSingleTrianglesFill) {
  HandMesh layers;
  for (int i = 0; i < 1500; ++i)
    layers.quad(-50, -50, 50, 50, -10.0F - 1e-3F * static_cast<float>(i));
  const DrawnSheet drawn = draw(layers, true, false, 1.0, std::chrono::nanoseconds(1));
  EXPECT_TRUE(drawn.out_of_time);
  EXPECT_EQ(coveredCells(), 0U);
}

TEST_F(SheetTest, AnObjectOfEndlessLayersIsGivenUpWithoutATimeLimit) {
  HandMesh layers;
  for (int i = 0; i < 1500; ++i)
    layers.quad(-50, -50, 50, 50, -20.0F + 1e-3F * static_cast<float>(i));
  const DrawnSheet drawn = draw(layers, true);
  EXPECT_FALSE(drawn.out_of_time);
  EXPECT_LT(drawn.triangles, layers.triangles.size() / 10);
}

TEST_F(SheetTest, AGapThinnerThanACellStaysOpen) {
  HandMesh wall;
  wall.quad(-50, -50, 0.0F, 50, -10);
  wall.quad(1e-4F, -50, 50, 50, -10);
  draw(wall);
  const std::uint32_t middle = view_.grid.width / 2;
  for (std::uint32_t y = 0; y < view_.grid.height; ++y) {
    EXPECT_TRUE(cellAt(middle, y) == 0.0F || cellAt(middle - 1, y) == 0.0F);
  }
}

TEST_F(SheetTest, AFoldedDoubleSidedSheetIsOpenBeyondItsFold) {
  HandMesh sheet;  // both halves lie left of x = 0 and meet there: crossing the fold leaves both
  sheet.triangle({0, -50, -10}, {0, 50, -10}, {-50, 0, -10});
  sheet.triangle({0, 50, -10}, {0, -50, -10}, {-50, 0, -12});
  draw(sheet, true);
  for (std::uint32_t x = view_.grid.width / 2; x < view_.grid.width; ++x)
    EXPECT_EQ(cellAt(x, 180), 0.0F);
}

TEST_F(SheetTest, AWallBesideTheEyeReachingBehindItCoversItsSideOnly) {
  HandMesh wall;  // x = -1, from 40 m behind the eye to 40 m ahead, facing +x
  wall.triangle({-1, -30, 40}, {-1, -30, -40}, {-1, 30, -40});
  wall.triangle({-1, -30, 40}, {-1, 30, -40}, {-1, 30, 40});
  draw(wall);
  EXPECT_GT(cellAt(1, 180), 0.0F);
  EXPECT_EQ(cellAt(view_.grid.width / 2 + 2, 180), 0.0F);
}

TEST_F(SheetTest, NothingNearerThanTheNearPlaneBlocks) {
  LookAt look;
  look.znear_m = 2.0;
  setCamera(look);
  HandMesh wall;
  wall.quad(-50, -50, 50, 50, -1.5F);
  draw(wall);
  EXPECT_EQ(coveredCells(), 0U);
}

}  // namespace
}  // namespace culld
