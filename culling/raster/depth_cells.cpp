#include "culling/raster/depth_cells.h"

#include <algorithm>
#include <bit>

#include "culling/raster/coverage_kernels.h"

namespace culld {
namespace {

constexpr std::uint32_t kTileBlocks = kTileSide * kTileSide;
constexpr float kNearestOfAll = 3.0e38F;

/// Of the 64 blocks of a tile; in eight lanes, so that compilers use them.
float leastOf(const float* blocks) {
  std::array<float, 8> least;
  std::copy_n(blocks, 8, least.begin());
  for (std::uint32_t i = 8; i < kTileBlocks; i += 8) {
    for (std::uint32_t k = 0; k < 8; ++k) least[k] = std::min(least[k], blocks[i + k]);
  }
  return *std::min_element(least.begin(), least.end());
}

}  // namespace

std::uint64_t squareMask(const CellRect& rect, std::uint32_t x, std::uint32_t y) noexcept {
  const std::uint32_t x0 = std::max(rect.x0, x) - x, x1 = std::min(rect.x1 - x, 7U);
  const std::uint32_t y0 = std::max(rect.y0, y) - y, y1 = std::min(rect.y1 - y, 7U);
  const std::uint64_t row = (0xFFU << x0 & 0xFFU) & (0xFFU >> (7 - x1));
  const std::uint64_t rows =
      (~std::uint64_t{0} << (8 * y0)) & (~std::uint64_t{0} >> (8 * (7 - y1)));
  return row * 0x0101010101010101U & rows;
}

void DepthCells::reset(const CellGrid& grid) {
  grid_ = grid;
  least_.assign(grid.blocks(), 0.0F);
  tile_least_.assign(grid.tiles(), 0.0F);
  tile_stale_.assign(grid.tiles(), 1);
  raised_.assign(grid.tiles(), 0);
  if (cells_.size() < grid.blocks()) cells_.resize(grid.blocks());
  if (used_in_.size() < grid.blocks()) used_in_.resize(grid.blocks(), 0);
  if (++frame_ == 0) {  // after 2^32 frames the old marks could be mistaken for this frame's
    std::fill(used_in_.begin(), used_in_.end(), 0);
    frame_ = 1;
  }
}

/// Nothing can be seen past the image's rim: cells there do not keep a block from being all hidden.
void DepthCells::hidePastTheRim(std::uint32_t block) {
  const std::uint32_t tile = block / kTileBlocks, within = block % kTileBlocks;
  const std::uint32_t x = (tile % grid_.tiles_x * kTileSide + within % kTileSide) * kBlockSide;
  const std::uint32_t y = (tile / grid_.tiles_x * kTileSide + within / kTileSide) * kBlockSide;
  if (x + kBlockSide <= grid_.width && y + kBlockSide <= grid_.height) return;
  for (std::uint32_t i = 0; i < 64; ++i) {
    const bool past = x + i % kBlockSide >= grid_.width || y + i / kBlockSide >= grid_.height;
    if (past) cells_[block][i] = kNearestOfAll;
  }
}

float* DepthCells::cells(std::uint32_t block) {
  markRaised(block);
  if (used_in_[block] != frame_) {
    used_in_[block] = frame_;
    cells_[block].fill(0.0F);
    hidePastTheRim(block);
  }
  return cells_[block].data();
}

bool DepthCells::cellsHide(std::uint32_t block_x, std::uint32_t block_y, const CellRect& rect,
                           float nearest) const {
  const std::uint32_t block = grid_.blockAt(block_x, block_y);
  if (used_in_[block] != frame_) return false;
  const std::uint64_t hiding = cellsNearerThan(cells_[block].data(), nearest);
  return (squareMask(rect, block_x * kBlockSide, block_y * kBlockSide) & ~hiding) == 0;
}

bool DepthCells::tileHides(std::uint32_t tile_x, std::uint32_t tile_y, const CellRect& rect,
                           float nearest) {
  const std::uint32_t tile = tile_y * grid_.tiles_x + tile_x;
  const float* least = least_.data() + std::size_t{tile} * kTileBlocks;
  if (tile_stale_[tile] != 0) setLeastOfTile(tile, leastOf(least));
  if (tile_least_[tile] > nearest) return true;
  const std::uint32_t left = tile_x * kTileSide, bottom = tile_y * kTileSide;
  const CellRect blocks{rect.x0 / kBlockSide, rect.x1 / kBlockSide, rect.y0 / kBlockSide,
                        rect.y1 / kBlockSide};
  std::uint64_t open = squareMask(blocks, left, bottom) & ~cellsNearerThan(least, nearest);
  for (; open != 0; open &= open - 1) {
    const auto bit = static_cast<std::uint32_t>(std::countr_zero(open));
    if (!cellsHide(left + bit % kTileSide, bottom + bit / kTileSide, rect, nearest)) return false;
  }
  return true;
}

bool DepthCells::certainlyHidden(const CellRect& rect, float nearest) {
  const std::uint32_t x0 = rect.x0 / kBlockSide, x1 = rect.x1 / kBlockSide;
  const std::uint32_t y0 = rect.y0 / kBlockSide, y1 = rect.y1 / kBlockSide;
  if (x1 - x0 <= 1 && y1 - y0 <= 1) {  // few blocks: most objects
    for (std::uint32_t y = y0; y <= y1; ++y) {
      for (std::uint32_t x = x0; x <= x1; ++x) {
        const bool whole = least_[grid_.blockAt(x, y)] > nearest;
        if (!whole && !cellsHide(x, y, rect, nearest)) return false;
      }
    }
    return true;
  }
  for (std::uint32_t y = y0 / kTileSide; y <= y1 / kTileSide; ++y) {
    for (std::uint32_t x = x0 / kTileSide; x <= x1 / kTileSide; ++x) {
      if (!tileHides(x, y, rect, nearest)) return false;
    }
  }
  return true;
}

std::size_t DepthCells::bytes() const noexcept {
  return (least_.capacity() + tile_least_.capacity()) * sizeof(float) + tile_stale_.capacity() +
         raised_.capacity() * sizeof(std::uint64_t) + cells_.capacity() * sizeof(cells_[0]) +
         used_in_.capacity() * sizeof(std::uint32_t);
}

}  // namespace culld
