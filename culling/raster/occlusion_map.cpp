#include "culling/raster/occlusion_map.h"

#include <algorithm>
#include <bit>

#include "culling/raster/box_cells.h"
#include "culling/raster/coverage_kernels.h"

namespace culld {
namespace {

constexpr std::uint32_t kBlockCells = kBlockSide * kBlockSide;

/// Bits of the block's cells that nothing is proven of.
std::uint64_t uncovered(const DepthCells& cells, std::uint32_t block) {
  if (cells.leastNearness(block) > 0.0F) return 0;
  const float* drawn = cells.readCells(block);
  return drawn == nullptr ? ~std::uint64_t{0} : ~cellsNearerThan(drawn, 0.0F);
}

}  // namespace

std::uint32_t negligibleHole(double opacity) noexcept {
  const double open = (1.0 - opacity) * kBlockCells;
  return open > 0.0 ? static_cast<std::uint32_t>(std::min(open, 64.0)) : 0;
}

void OcclusionMap::addLevel() {
  const Level& below = levels_.back();
  Level level;
  level.width = (below.width + 1) / 2;
  level.height = (below.height + 1) / 2;
  level.open.assign(std::size_t{level.width} * level.height, 0);
  for (std::uint32_t y = 0; y < below.height; ++y) {
    for (std::uint32_t x = 0; x < below.width; ++x) {
      level.open[std::size_t{y / 2} * level.width + x / 2] += below.at(x, y);
    }
  }
  levels_.push_back(std::move(level));
}

void OcclusionMap::build(DepthCells& cells, std::uint32_t levels) {
  grid_ = cells.grid();
  const CellRect all = everyCell(grid_);
  open_.resize(std::size_t{grid_.blocks_x} * grid_.blocks_y);
  Level level;
  level.width = grid_.blocks_x;
  level.height = grid_.blocks_y;
  level.open.resize(open_.size());
  for (std::uint32_t y = 0; y < grid_.blocks_y; ++y) {
    for (std::uint32_t x = 0; x < grid_.blocks_x; ++x) {
      const std::size_t i = std::size_t{y} * grid_.blocks_x + x;
      open_[i] =
          uncovered(cells, grid_.blockAt(x, y)) & squareMask(all, x * kBlockSide, y * kBlockSide);
      level.open[i] = static_cast<std::uint32_t>(std::popcount(open_[i]));
    }
  }
  levels_.clear();
  levels_.push_back(std::move(level));
  while (levels_.size() <= std::min(levels, kMostMapLevels) &&
         (levels_.back().width > 1 || levels_.back().height > 1)) {
    addLevel();
  }
}

CellRect OcclusionMap::cellsOf(std::uint32_t level, std::uint32_t x,
                               std::uint32_t y) const noexcept {
  const std::uint32_t side = kBlockSide << level;
  return {x * side, std::min((x + 1) * side, grid_.width) - 1, y * side,
          std::min((y + 1) * side, grid_.height) - 1};
}

double OcclusionMap::opacity(std::uint32_t level, std::uint32_t x, std::uint32_t y) const noexcept {
  return 1.0 - static_cast<double>(levels_[level].at(x, y)) /
                   static_cast<double>(cellsOf(level, x, y).cells());
}

bool OcclusionMap::texelCovered(std::uint32_t level, std::uint32_t x, std::uint32_t y,
                                Query& query) const {
  ++query.texels;
  const std::uint32_t open = levels_[level].at(x, y), hole = query.rules.hole;
  if (open <= hole) return true;
  const CellRect cells = cellsOf(level, x, y);
  const CellRect& rect = query.rect;
  const bool inside =
      rect.x0 <= cells.x0 && cells.x1 <= rect.x1 && rect.y0 <= cells.y0 && cells.y1 <= rect.y1;
  // Finer levels forgive a hole in each block; not even so many are left.
  if (inside && open > std::uint64_t{hole} << (2 * level)) return false;
  const auto count = static_cast<double>(cells.cells());
  if (static_cast<double>(open) >= query.rules.give_up * count) return false;
  if (level == 0) {
    const std::uint64_t under = squareMask(rect, cells.x0, cells.y0) & openCells(x, y);
    return static_cast<std::uint32_t>(std::popcount(under)) <= hole;
  }
  const std::uint32_t side = kBlockSide << (level - 1);
  const std::uint32_t first_x = std::max(2 * x, rect.x0 / side);
  const std::uint32_t last_x = std::min(2 * x + 1, rect.x1 / side);
  const std::uint32_t last_y = std::min(2 * y + 1, rect.y1 / side);
  for (std::uint32_t j = std::max(2 * y, rect.y0 / side); j <= last_y; ++j) {
    for (std::uint32_t i = first_x; i <= last_x; ++i) {
      if (!texelCovered(level - 1, i, j, query)) return false;
    }
  }
  return true;
}

Overlap OcclusionMap::overlap(const CellRect& rect, const OverlapRules& rules) const {
  std::uint32_t level = 0;
  const auto apart = [&](std::uint32_t low, std::uint32_t high) {
    const std::uint32_t side = kBlockSide << level;
    return high / side - low / side > 1;
  };
  while (level < levels() && (apart(rect.x0, rect.x1) || apart(rect.y0, rect.y1))) ++level;
  Query query{rect, rules, 0};
  const std::uint32_t side = kBlockSide << level;
  for (std::uint32_t y = rect.y0 / side; y <= rect.y1 / side; ++y) {
    for (std::uint32_t x = rect.x0 / side; x <= rect.x1 / side; ++x) {
      if (!texelCovered(level, x, y, query)) return {false, query.texels};
    }
  }
  return {true, query.texels};
}

}  // namespace culld
