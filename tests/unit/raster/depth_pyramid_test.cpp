#include "culling/raster/depth_pyramid.h"

#include <gtest/gtest.h>

#include <random>

namespace culld {
namespace {

/// Cells raised at random, in blocks, tiles of blocks and one by one, as drawing does.
class DepthPyramidTest : public testing::Test {
 protected:
  void begin(std::uint32_t width, std::uint32_t height) {
    grid_ = gridOf(width, height);
    cells_.reset(grid_);
    pyramid_.reset(grid_);
  }
  CellRect everything() const { return {0, grid_.width - 1, 0, grid_.height - 1}; }

  float nearness() { return std::uniform_real_distribution<float>(0.1F, 1.0F)(random_); }

  /// Raises something; returns the cells concerned.
  CellRect raise() {
    const auto x = static_cast<std::uint32_t>(random_() % grid_.blocks_x);
    const auto y = static_cast<std::uint32_t>(random_() % grid_.blocks_y);
    const std::uint32_t block = grid_.blockAt(x, y);
    if (random_() % 2 == 0) {
      cells_.setLeastNearness(block, std::max(cells_.leastNearness(block), nearness()));
    } else {
      float* cells = cells_.cells(block);
      for (int i = 0; i < 20; ++i) {
        float& cell = cells[random_() % 64];
        cell = std::max(cell, nearness());
      }
    }
    return {8 * x, std::min(8 * x + 7, grid_.width - 1), 8 * y,
            std::min(8 * y + 7, grid_.height - 1)};
  }

  float cellAt(std::uint32_t x, std::uint32_t y) const {
    const std::uint32_t block = grid_.blockAt(x / 8, y / 8);
    const float* cells = cells_.readCells(block);
    const float least = cells_.leastNearness(block);
    return cells == nullptr ? least : std::max(least, cells[y % 8 * 8 + x % 8]);
  }

  /// The least of the cells below a cell of a level, as far as they are on the image.
  float leastBelow(std::uint32_t level, std::uint32_t x, std::uint32_t y) const {
    float least = 3.0e38F;
    for (std::uint32_t v = y << level; v < (y + 1) << level && v < grid_.height; ++v) {
      for (std::uint32_t u = x << level; u < (x + 1) << level && u < grid_.width; ++u) {
        least = std::min(least, cellAt(u, v));
      }
    }
    return least;
  }

  void expectEveryValueIsTheLeastBelow() const {
    for (std::uint32_t level = 0; level <= pyramid_.topLevel(); ++level) {
      for (std::uint32_t y = 0; y <= (grid_.height - 1) >> level; ++y) {
        for (std::uint32_t x = 0; x <= (grid_.width - 1) >> level; ++x) {
          ASSERT_EQ(pyramid_.at(level, x, y), leastBelow(level, x, y))
              << level << ": " << x << ", " << y;
        }
      }
    }
  }

  bool everyCellHides(const CellRect& rect, float nearest) const {
    for (std::uint32_t y = rect.y0; y <= rect.y1; ++y) {
      for (std::uint32_t x = rect.x0; x <= rect.x1; ++x) {
        if (!(cellAt(x, y) > nearest)) return false;
      }
    }
    return true;
  }

  BoxProbe anyProbe() {
    BoxProbe probe;
    const auto range = [&](std::uint32_t side, std::uint32_t& low, std::uint32_t& high) {
      low = static_cast<std::uint32_t>(random_() % side);
      high = std::min(low + static_cast<std::uint32_t>(random_() % 40), side - 1);
    };
    range(grid_.width, probe.rect.x0, probe.rect.x1);
    range(grid_.height, probe.rect.y0, probe.rect.y1);
    probe.nearest = std::uniform_real_distribution<float>(0.0F, 0.5F)(random_);
    return probe;
  }

  CellGrid grid_;
  DepthCells cells_;
  DepthPyramid pyramid_;
  std::mt19937_64 random_{7};
};

TEST_F(DepthPyramidTest, EveryValueIsTheLeastOfItsWindowAfterEveryWrite) {
  for (const auto& [width, height] : {std::pair{64U, 64U}, {83U, 41U}, {1U, 1U}, {300U, 9U}}) {
    begin(width, height);
    expectEveryValueIsTheLeastBelow();
    for (int i = 0; i < 60; ++i) {
      pyramid_.update(cells_, raise());
      expectEveryValueIsTheLeastBelow();
    }
  }
}

TEST_F(DepthPyramidTest, ARebuildGivesTheSameForManyTimesTheWrites) {
  begin(256, 144);
  for (int i = 0; i < 200; ++i) pyramid_.update(cells_, raise());
  const std::uint64_t incremental = pyramid_.writes();
  expectEveryValueIsTheLeastBelow();
  pyramid_.rebuild(cells_);
  expectEveryValueIsTheLeastBelow();
  // One block at a time against all 576.
  EXPECT_LT(incremental / 200, (pyramid_.writes() - incremental) / 100);
}

TEST_F(DepthPyramidTest, HidesWhatEveryCellHidesAndNothingElse) {
  std::size_t hidden = 0, open = 0;
  for (std::uint64_t round = 0; round < 40; ++round) {
    begin(120 + static_cast<std::uint32_t>(random_() % 60), 70);
    for (int i = 0; i < 900; ++i) pyramid_.update(cells_, raise());
    for (int i = 0; i < 300; ++i) {
      const BoxProbe probe = anyProbe();
      const bool expected = everyCellHides(probe.rect, probe.nearest);
      for (const std::uint32_t levels : {0U, 1U, 4U, DepthPyramid::kAllLevels}) {
        OpenCell cell;
        ASSERT_EQ(pyramid_.hides(probe, levels, cell), expected);
        if (!expected) {
          EXPECT_TRUE(pyramid_.stillOpen(cell));
          EXPECT_FALSE(cellAt(cell.x, cell.y) > probe.nearest);
          EXPECT_TRUE(cell.x >= probe.rect.x0 && cell.x <= probe.rect.x1);
          EXPECT_TRUE(cell.y >= probe.rect.y0 && cell.y <= probe.rect.y1);
        }
      }
      ++(expected ? hidden : open);
    }
  }
  EXPECT_GT(hidden, 500U);
  EXPECT_GT(open, 500U);
}

TEST_F(DepthPyramidTest, EqualNearnessHidesNothing) {
  begin(64, 64);
  for (std::uint32_t b = 0; b < 64; ++b) cells_.setLeastNearness(grid_.blockAt(b % 8, b / 8), 0.5F);
  pyramid_.update(cells_, everything());
  BoxProbe probe;
  probe.rect = everything();
  probe.nearest = 0.5F;
  OpenCell cell;
  EXPECT_FALSE(pyramid_.hides(probe, DepthPyramid::kAllLevels, cell));
  probe.nearest = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FALSE(pyramid_.hides(probe, DepthPyramid::kAllLevels, cell));
  probe.nearest = std::nextafter(0.5F, 0.0F);
  EXPECT_TRUE(pyramid_.hides(probe, DepthPyramid::kAllLevels, cell));
}

TEST_F(DepthPyramidTest, HidesALargeBoxWithOneComparison) {
  begin(64, 64);
  for (std::uint32_t b = 0; b < 64; ++b) cells_.setLeastNearness(grid_.blockAt(b % 8, b / 8), 0.5F);
  pyramid_.update(cells_, everything());
  BoxProbe probe;
  probe.rect = {3, 60, 3, 60};
  probe.nearest = 0.25F;
  OpenCell cell;
  EXPECT_TRUE(pyramid_.hides(probe, DepthPyramid::kAllLevels, cell));
  EXPECT_EQ(pyramid_.comparisons(), 1U);
  EXPECT_TRUE(pyramid_.hides(probe, 0, cell));
  EXPECT_EQ(pyramid_.comparisons(), 1U + 58U * 58U);
}

TEST_F(DepthPyramidTest, ForgetsTheFrameBefore) {
  begin(64, 64);
  for (int i = 0; i < 50; ++i) pyramid_.update(cells_, raise());
  begin(64, 64);
  expectEveryValueIsTheLeastBelow();
  EXPECT_EQ(pyramid_.at(pyramid_.topLevel(), 0, 0), 0.0F);
}

}  // namespace
}  // namespace culld
