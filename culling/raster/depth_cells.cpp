#include "culling/raster/depth_cells.h"

#include <algorithm>

#include "culling/raster/coverage_kernels.h"

namespace culld {
namespace {

/// Bits of the block's cells within [x0, x1] x [y0, y1], coordinates relative to the block.
std::uint64_t rectMask(std::uint32_t x0, std::uint32_t x1, std::uint32_t y0, std::uint32_t y1) {
  const std::uint64_t row = (0xFFU << x0 & 0xFFU) & (0xFFU >> (7 - x1));
  std::uint64_t mask = 0;
  for (std::uint32_t y = y0; y <= y1; ++y) mask |= row << (8 * y);
  return mask;
}

}  // namespace

void DepthCells::reset(const CellGrid& grid) {
  grid_ = grid;
  least_.assign(grid.blocks(), 0.0F);
  if (cells_.size() < grid.blocks()) cells_.resize(grid.blocks());
  if (used_in_.size() < grid.blocks()) used_in_.resize(grid.blocks(), 0);
  if (++frame_ == 0) {  // after 2^32 frames the old marks could be mistaken for this frame's
    std::fill(used_in_.begin(), used_in_.end(), 0);
    frame_ = 1;
  }
}

float* DepthCells::cells(std::uint32_t block) {
  if (used_in_[block] != frame_) {
    used_in_[block] = frame_;
    cells_[block].fill(0.0F);
  }
  return cells_[block].data();
}

bool DepthCells::blockHides(std::uint32_t block_x, std::uint32_t block_y, const CellRect& rect,
                            float nearest) const {
  const std::uint32_t block = block_y * grid_.blocks_x + block_x;
  if (least_[block] > nearest) return true;
  if (used_in_[block] != frame_) return false;
  const std::uint32_t left = block_x * kBlockSide, bottom = block_y * kBlockSide;
  const std::uint32_t x0 = std::max(rect.x0, left) - left, y0 = std::max(rect.y0, bottom) - bottom;
  const std::uint32_t x1 = std::min(rect.x1 - left, kBlockSide - 1);
  const std::uint32_t y1 = std::min(rect.y1 - bottom, kBlockSide - 1);
  return (rectMask(x0, x1, y0, y1) & ~cellsNearerThan(cells_[block].data(), nearest)) == 0;
}

bool DepthCells::certainlyHidden(const CellRect& rect, float nearest) const {
  for (std::uint32_t y = rect.y0 / kBlockSide; y <= rect.y1 / kBlockSide; ++y) {
    for (std::uint32_t x = rect.x0 / kBlockSide; x <= rect.x1 / kBlockSide; ++x) {
      if (!blockHides(x, y, rect, nearest)) return false;
    }
  }
  return true;
}

std::size_t DepthCells::bytes() const noexcept {
  return least_.capacity() * sizeof(float) + cells_.capacity() * sizeof(cells_[0]) +
         used_in_.capacity() * sizeof(std::uint32_t);
}

}  // namespace culld
