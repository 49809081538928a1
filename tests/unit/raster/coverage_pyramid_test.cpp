#include "culling/raster/coverage_pyramid.h"

#include <gtest/gtest.h>

#include <random>

namespace culld {
namespace {

class CoveragePyramidTest : public testing::Test {
 protected:
  void begin(std::uint32_t width, std::uint32_t height) {
    grid_ = gridOf(width, height);
    cells_.reset(grid_);
    coverage_.reset(grid_);
  }
  void cover(const CellRect& r) {
    for (std::uint32_t y = r.y0; y <= r.y1; ++y) {
      for (std::uint32_t x = r.x0; x <= r.x1; ++x) {
        cells_.cells(grid_.blockAt(x / 8, y / 8))[y % 8 * 8 + x % 8] = 0.5F;
      }
    }
    coverage_.update(cells_, r);
  }
  bool everyCell(const CellRect& r) const {
    for (std::uint32_t y = r.y0; y <= r.y1; ++y) {
      for (std::uint32_t x = r.x0; x <= r.x1; ++x) {
        const std::uint32_t block = grid_.blockAt(x / 8, y / 8);
        const float* cells = cells_.readCells(block);
        const bool covered = cells_.leastNearness(block) > 0.0F ||
                             (cells != nullptr && cells[y % 8 * 8 + x % 8] > 0.0F);
        if (!covered) return false;
      }
    }
    return true;
  }
  CellRect anyRect(std::uint32_t most) {
    const auto x = static_cast<std::uint32_t>(random_() % grid_.width);
    const auto y = static_cast<std::uint32_t>(random_() % grid_.height);
    return {x, std::min(x + static_cast<std::uint32_t>(random_() % most), grid_.width - 1), y,
            std::min(y + static_cast<std::uint32_t>(random_() % most), grid_.height - 1)};
  }

  CellGrid grid_;
  DepthCells cells_;
  CoveragePyramid coverage_;
  std::mt19937_64 random_{5};
};

TEST_F(CoveragePyramidTest, CoversWhatEveryCellDoesAndNothingElse) {
  std::size_t covered = 0, open = 0;
  for (const auto& [width, height] : {std::pair{640U, 360U}, {83U, 41U}, {1U, 1U}, {700U, 9U}}) {
    begin(width, height);
    for (int i = 0; i < 80; ++i) {
      cover(anyRect(160));
      if (i % 4 == 0) {
        const auto x = static_cast<std::uint32_t>(random_() % grid_.blocks_x);
        const auto y = static_cast<std::uint32_t>(random_() % grid_.blocks_y);
        cells_.setLeastNearness(grid_.blockAt(x, y), 0.1F);
        coverage_.update(cells_, {8 * x, 8 * x, 8 * y, 8 * y});
      }
      for (int k = 0; k < 60; ++k) {
        const CellRect rect = anyRect(k % 2 == 0 ? 20 : 300);
        const bool expected = everyCell(rect);
        for (const std::uint32_t levels : {0U, 1U, CoveragePyramid::kAllLevels}) {
          ASSERT_EQ(coverage_.covers(rect, levels), expected);
        }
        ++(expected ? covered : open);
      }
    }
  }
  EXPECT_GT(covered, 500U);
  EXPECT_GT(open, 500U);
}

TEST_F(CoveragePyramidTest, AsksOneMaskWhereAllIsCoveredOrVacant) {
  begin(512, 512);
  EXPECT_FALSE(coverage_.covers({1, 500, 1, 500}, CoveragePyramid::kAllLevels));
  EXPECT_EQ(coverage_.masksCompared(), 1U);
  cover({0, 511, 0, 511});
  EXPECT_TRUE(coverage_.covers({1, 500, 1, 500}, CoveragePyramid::kAllLevels));
  EXPECT_EQ(coverage_.masksCompared(), 2U);
  EXPECT_TRUE(coverage_.covers({1, 500, 1, 500}, 0));
  EXPECT_EQ(coverage_.masksCompared(), 2U + 63U * 63U);
}

}  // namespace
}  // namespace culld
