#include "culling/raster/depth_cells.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace culld {
namespace {

TEST(DepthCells, AnswersAsABruteForceScanOfTheRectangle) {
  std::mt19937_64 random(3);
  const CellGrid grid = gridOf(261, 137);
  DepthCells cells;
  for (int round = 0; round < 200; ++round) {
    cells.reset(grid);
    for (std::uint32_t block = 0; block < grid.blocks(); ++block) {
      if (random() % 512 == 0) continue;  // never used: nothing is proven
      float* c = cells.cells(block);
      for (int i = 0; i < 64; ++i) c[i] = random() % 16384 == 0 ? 0.1F : 0.5F;
      cells.setLeastNearness(block, *std::min_element(c, c + 64));
    }
    for (int query = 0; query < 50; ++query) {
      CellRect rect{
          static_cast<std::uint32_t>(random() % 261), static_cast<std::uint32_t>(random() % 261),
          static_cast<std::uint32_t>(random() % 137), static_cast<std::uint32_t>(random() % 137)};
      if (query % 2 == 0) rect = {rect.x0, rect.x0 + 1, rect.y0, rect.y0 + 1};
      if (rect.x0 > rect.x1) std::swap(rect.x0, rect.x1);
      if (rect.y0 > rect.y1) std::swap(rect.y0, rect.y1);
      rect.x1 = std::min(rect.x1, 260U);
      rect.y1 = std::min(rect.y1, 136U);
      const float nearest = random() % 2 == 0 ? 0.3F : 0.05F;
      bool hidden = true;
      for (std::uint32_t y = rect.y0; y <= rect.y1; ++y) {
        for (std::uint32_t x = rect.x0; x <= rect.x1; ++x) {
          const std::uint32_t block = grid.blockAt(x / 8, y / 8);
          hidden = hidden && cells.cells(block)[y % 8 * 8 + x % 8] > nearest;
        }
      }
      ASSERT_EQ(cells.certainlyHidden(rect, nearest), hidden);
    }
  }
}

TEST(DepthCells, ForgetsTheLastFrame) {
  DepthCells cells;
  cells.reset(gridOf(8, 8));
  std::fill_n(cells.cells(0), 64, 1.0F);
  cells.setLeastNearness(0, 1.0F);
  EXPECT_TRUE(cells.certainlyHidden({0, 7, 0, 7}, 0.5F));
  cells.reset(gridOf(8, 8));
  EXPECT_FALSE(cells.certainlyHidden({0, 7, 0, 7}, 0.5F));
  EXPECT_EQ(cells.cells(0)[13], 0.0F);
}

TEST(DepthCells, EqualNearnessDoesNotHide) {
  DepthCells cells;
  cells.reset(gridOf(8, 8));
  std::fill_n(cells.cells(0), 64, 0.5F);
  cells.setLeastNearness(0, 0.5F);
  EXPECT_FALSE(cells.certainlyHidden({2, 3, 2, 3}, 0.5F));
}

}  // namespace
}  // namespace culld
