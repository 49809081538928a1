#include "culling/raster/occlusion_map.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <random>

#include "culling/raster/box_cells.h"
#include "culling/raster/depth_estimation.h"
#include "culling/raster/hole_ledger.h"

namespace culld {
namespace {

/// Cells that are covered but for a few, drawn by hand.
class Drawing {
 public:
  explicit Drawing(const CellGrid& grid) {
    cells_.reset(grid);
    fill(everyCell(grid), 0.5F);
  }
  void fill(const CellRect& rect, float nearness) {
    for (std::uint32_t y = rect.y0; y <= rect.y1; ++y) {
      for (std::uint32_t x = rect.x0; x <= rect.x1; ++x) set(x, y, nearness);
    }
  }
  void set(std::uint32_t x, std::uint32_t y, float nearness) {
    const std::uint32_t block = grid().blockAt(x / kBlockSide, y / kBlockSide);
    float* c = cells_.cells(block);
    c[y % kBlockSide * kBlockSide + x % kBlockSide] = nearness;
    cells_.setLeastNearness(block, *std::min_element(c, c + 64));
  }
  float at(std::uint32_t x, std::uint32_t y) {
    const float* c = cells_.cells(grid().blockAt(x / kBlockSide, y / kBlockSide));
    return c[y % kBlockSide * kBlockSide + x % kBlockSide];
  }
  const CellGrid& grid() const { return cells_.grid(); }
  DepthCells& cells() { return cells_; }
  OcclusionMap map(std::uint32_t levels = kMostMapLevels) {
    OcclusionMap map;
    map.build(cells_, levels);
    return map;
  }

 private:
  DepthCells cells_;
};

CellRect randomRect(const CellGrid& grid, std::mt19937_64& random) {
  const auto below = [&](std::uint32_t n) { return static_cast<std::uint32_t>(random() % n); };
  CellRect rect{below(grid.width), below(grid.width), below(grid.height), below(grid.height)};
  if (random() % 2 == 0) rect = {rect.x0, rect.x0 + below(12), rect.y0, rect.y0 + below(12)};
  if (rect.x0 > rect.x1) std::swap(rect.x0, rect.x1);
  if (rect.y0 > rect.y1) std::swap(rect.y0, rect.y1);
  return {rect.x0, std::min(rect.x1, grid.width - 1), rect.y0, std::min(rect.y1, grid.height - 1)};
}

TEST(OcclusionMap, IsAsOpaqueAsTheMeanOfItsCells) {
  std::mt19937_64 random(7);
  Drawing drawing(gridOf(261, 137));
  for (int i = 0; i < 9000; ++i) {
    drawing.set(static_cast<std::uint32_t>(random() % 261),
                static_cast<std::uint32_t>(random() % 137), 0.0F);
  }
  const OcclusionMap map = drawing.map();
  EXPECT_EQ(map.levels(), 6U);  // 33 x 18 texels, 17 x 9, 9 x 5, 5 x 3, 3 x 2, 2 x 1, 1
  for (std::uint32_t level = 0; level <= map.levels(); ++level) {
    const std::uint32_t side = kBlockSide << level;
    for (std::uint32_t y = 0; y < 137; y += side) {
      for (std::uint32_t x = 0; x < 261; x += side) {
        double covered = 0.0, all = 0.0;
        for (std::uint32_t j = y; j < std::min(y + side, 137U); ++j) {
          for (std::uint32_t i = x; i < std::min(x + side, 261U); ++i) {
            covered += drawing.at(i, j) > 0.0F ? 1.0 : 0.0;
            all += 1.0;
          }
        }
        ASSERT_NEAR(map.opacity(level, x / side, y / side), covered / all, 1e-12);
      }
    }
  }
}

TEST(OcclusionMap, FindsOverlapAsABruteForceScanDoesAtEveryDepthOfThePyramid) {
  std::mt19937_64 random(3);
  for (int round = 0; round < 40; ++round) {
    Drawing drawing(gridOf(261, 137));
    for (int i = 0; i < 1 << (round % 12); ++i) {
      drawing.set(static_cast<std::uint32_t>(random() % 261),
                  static_cast<std::uint32_t>(random() % 137), 0.0F);
    }
    const OcclusionMap maps[] = {drawing.map(0), drawing.map(2), drawing.map()};
    for (int query = 0; query < 200; ++query) {
      const CellRect rect = randomRect(drawing.grid(), random);
      bool covered = true;
      for (std::uint32_t y = rect.y0; y <= rect.y1; ++y) {
        for (std::uint32_t x = rect.x0; x <= rect.x1; ++x) {
          covered = covered && drawing.at(x, y) > 0.0F;
        }
      }
      for (const OcclusionMap& map : maps) ASSERT_EQ(map.overlap(rect, {}).covered, covered);
    }
  }
}

TEST(OcclusionMap, LooksAtFewerTexelsTheMoreLevelsItHas) {
  Drawing drawing(gridOf(1280, 720));
  const CellRect wide{3, 1270, 5, 700};
  const Overlap flat = drawing.map(0).overlap(wide, {});
  const Overlap deep = drawing.map().overlap(wide, {});
  EXPECT_TRUE(flat.covered && deep.covered);
  EXPECT_GT(flat.texels, 13'000U);
  EXPECT_LT(deep.texels, 10U);
}

TEST(OcclusionMap, GivesUpEarlyWhereATexelIsOpenEnough) {
  Drawing drawing(gridOf(512, 512));
  drawing.fill({0, 99, 0, 511}, 0.0F);
  const OcclusionMap map = drawing.map();
  const CellRect covered{104, 200, 4, 120};  // in texels that are open for the most part
  const Overlap patient = map.overlap(covered, {.hole = 0, .give_up = 1.0});
  const Overlap hasty = map.overlap(covered, {.hole = 0, .give_up = 0.5});
  EXPECT_TRUE(patient.covered);
  EXPECT_FALSE(hasty.covered);
  EXPECT_EQ(hasty.texels, 1U);
  EXPECT_GT(patient.texels, 10U);
}

TEST(OcclusionMap, ForgivesTheSameHoleAtEveryLevel) {
  // O[k + 1] = (3 + O[k]) / 4 is one number of cells: of 8 x 8, of 16 x 16, ...
  double opacity = 0.9375;
  EXPECT_EQ(negligibleHole(opacity), 4U);
  for (int level = 0; level < 6; ++level) {
    const double cells = std::ldexp(64.0, 2 * level);
    EXPECT_NEAR((1.0 - opacity) * cells, 4.0, 1e-9);
    opacity = (3.0 + opacity) / 4.0;
  }
  EXPECT_EQ(negligibleHole(1.0), 0U);
  EXPECT_EQ(negligibleHole(0.0), 64U);

  Drawing drawing(gridOf(256, 256));
  drawing.fill({40, 41, 40, 41}, 0.0F);
  const OcclusionMap map = drawing.map();
  const CellRect rect{8, 200, 8, 200};
  EXPECT_FALSE(map.overlap(rect, {}).covered);
  EXPECT_FALSE(map.overlap(rect, {.hole = 3}).covered);
  EXPECT_TRUE(map.overlap(rect, {.hole = 4}).covered);
  drawing.set(42, 42, 0.0F);  // one cell more in the same texel of level 0
  EXPECT_FALSE(drawing.map().overlap(rect, {.hole = 4}).covered);
  drawing.set(42, 42, 0.5F);
  drawing.fill({80, 81, 80, 81}, 0.0F);  // as large a hole in another: forgiven there too
  EXPECT_TRUE(drawing.map().overlap(rect, {.hole = 4}).covered);
}

TEST(HoleLedger, CountsEachOpenCellOnceAndStopsAtWhatIsAccepted) {
  Drawing drawing(gridOf(256, 128));
  drawing.fill({40, 41, 40, 41}, 0.0F);
  drawing.fill({60, 63, 40, 40}, 0.0F);
  const OcclusionMap map = drawing.map();
  HoleLedger ledger;
  ledger.reset(map, 4.0 * 256 * 128, 24.0);  // four pixels a cell
  EXPECT_TRUE(ledger.take({0, 20, 0, 100}));
  EXPECT_EQ(ledger.lostPx(), 0.0);
  EXPECT_TRUE(ledger.take({30, 50, 30, 50}));
  EXPECT_EQ(ledger.lostPx(), 16.0);
  EXPECT_TRUE(ledger.take({41, 45, 0, 127}));  // the same cells again
  EXPECT_EQ(ledger.lostPx(), 16.0);
  EXPECT_FALSE(ledger.take({30, 70, 30, 50}));  // four cells more: 32 pixels
  EXPECT_EQ(ledger.lostPx(), 16.0);
  EXPECT_TRUE(ledger.take({62, 70, 30, 50}));
  EXPECT_EQ(ledger.lostPx(), 24.0);
}

TEST(DepthEstimation, OfCellsHidesNothingThatACoveredCellUnderItDoesNot) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<float> unit(0.0F, 1.0F);
  for (const std::uint32_t regions : {1U, 7U, 64U, 256U}) {
    Drawing drawing(gridOf(261, 137));
    for (std::uint32_t y = 0; y < 137; ++y) {
      for (std::uint32_t x = 0; x < 261; ++x) {
        drawing.set(x, y, random() % 4 == 0 ? 0.0F : 0.5F + 0.01F * unit(random));
      }
    }
    DepthEstimation depth;
    depth.reset(drawing.grid(), regions);
    depth.addCells(drawing.cells());
    std::size_t behind = 0;
    for (int query = 0; query < 400; ++query) {
      const CellRect rect = randomRect(drawing.grid(), random);
      const float nearest = 0.499F + 0.004F * unit(random);
      if (!depth.behind(rect, nearest)) continue;
      ++behind;
      for (std::uint32_t y = rect.y0; y <= rect.y1; ++y) {
        for (std::uint32_t x = rect.x0; x <= rect.x1; ++x) {
          const float c = drawing.at(x, y);
          ASSERT_TRUE(c == 0.0F || c > nearest);
        }
      }
    }
    EXPECT_GT(behind, 20U);
  }
}

TEST(DepthEstimation, KeepsTheFarthestOfARegionsOccluders) {
  DepthEstimation depth;
  depth.reset(gridOf(256, 256), 64);
  const CellRect rect{16, 100, 16, 100};
  EXPECT_TRUE(depth.behind(rect, 1e30F));  // nothing stands there
  depth.add({0, 60, 0, 60}, 0.5F);
  EXPECT_TRUE(depth.behind(rect, 0.4F));
  EXPECT_FALSE(depth.behind(rect, 0.5F));  // equal depth hides nothing
  depth.add({59, 200, 0, 255}, 0.3F);
  EXPECT_FALSE(depth.behind(rect, 0.4F));
  EXPECT_TRUE(depth.behind({0, 55, 0, 60}, 0.4F));
  EXPECT_FALSE(depth.behind(rect, std::numeric_limits<float>::quiet_NaN()));
  EXPECT_FALSE(depth.behind({0, 255, 0, 255}, std::numeric_limits<float>::infinity()));
}

TEST(DepthEstimation, PutsABoxNoNearerThanItsFarthestPoint) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  for (int round = 0; round < 2000; ++round) {
    LookAt look;
    look.eye = {1e3 * unit(random), unit(random), unit(random)};
    look.target = look.eye + glm::dvec3(unit(random), unit(random), unit(random));
    const auto camera = cameraFromLookAt(look, {});
    if (!camera) continue;
    const CellView view = cellView(camera.value(), gridFor(camera.value()));
    std::array<double, 12> m;
    for (double& entry : m) entry = unit(random);
    for (const std::size_t i : {3U, 7U, 11U}) m[i] += look.eye[static_cast<int>(i / 4)];
    const Box box{{-0.5, -0.25, 0.0}, {0.5, 0.25, 0.125}};
    const ObjectRows rows = objectRows(view, m, camera.value().origin_world, {0.5, 0.25, 0.125});
    const float farthest = farthestNearness(rows, box, true);
    for (int i = 0; i < 8; ++i) {  // in 113 bits
      const long double p[3] = {i & 1 ? 0.5L : -0.5L, i & 2 ? 0.25L : -0.25L, i & 4 ? 0.125L : 0};
      long double w = 0;
      for (int r = 0; r < 3; ++r) {
        const auto row = static_cast<std::size_t>(4 * r);
        long double at = static_cast<long double>(m[row + 3]) -
                         static_cast<long double>(camera.value().origin_world[r]);
        for (std::size_t c = 0; c < 3; ++c) at += static_cast<long double>(m[row + c]) * p[c];
        w += at * static_cast<long double>(view.w[r]);
      }
      if (w > 0) {
        ASSERT_LE(static_cast<long double>(farthest) * w, 1.0L);
      }
    }
  }
}

}  // namespace
}  // namespace culld
