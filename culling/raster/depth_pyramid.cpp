#include "culling/raster/depth_pyramid.h"

#include <algorithm>
#include <bit>

namespace culld {
namespace {

/// Of cells past the image's rim: they hide everything, as nothing can be seen in them.
constexpr float kPastTheRim = 3.0e38F;

std::uint32_t half(std::uint32_t n) { return (n + 1) / 2; }

/// Least of each 2 x 2 window of a square of `side`.
template <std::size_t kIn, std::size_t kOut>
void reduce(const std::array<float, kIn>& in, std::uint32_t side, std::array<float, kOut>& out) {
  for (std::uint32_t y = 0; y < side / 2; ++y) {
    for (std::uint32_t x = 0; x < side / 2; ++x) {
      const float* low = in.data() + 2 * y * side + 2 * x;
      out[y * (side / 2) + x] =
          std::min(std::min(low[0], low[1]), std::min(low[side], low[side + 1]));
    }
  }
}

}  // namespace

void DepthPyramid::reset(const CellGrid& grid) {
  grid_ = grid;
  comparisons_ = writes_ = 0;
  std::uint32_t width = grid.blocks_x, height = grid.blocks_y;
  for (std::size_t i = 0;; ++i) {
    if (levels_.size() <= i) levels_.emplace_back();
    levels_[i].width = width;
    levels_[i].height = height;
    levels_[i].values.assign(std::size_t{width} * height, 0.0F);
    top_ = kBlockLevel + static_cast<std::uint32_t>(i);
    if (width <= 1 && height <= 1) break;
    width = half(width);
    height = half(height);
  }
  const std::size_t blocks = std::size_t{grid.blocks_x} * grid.blocks_y;
  if (blocks_.size() < blocks) blocks_.resize(blocks);
  if (raised_in_.size() < blocks) raised_in_.resize(blocks, 0);
  if (++frame_ == 0) {  // after 2^32 frames the old marks could be mistaken for this frame's
    std::fill(raised_in_.begin(), raised_in_.end(), 0);
    frame_ = 1;
  }
}

/// The block's own levels from its cells. Returns its value.
float DepthPyramid::refresh(const DepthCells& cells, std::uint32_t block_x, std::uint32_t block_y) {
  const std::size_t index = std::size_t{block_y} * grid_.blocks_x + block_x;
  const std::uint32_t block = grid_.blockAt(block_x, block_y);
  Block& to = blocks_[index];
  raised_in_[index] = frame_;
  const float least = cells.leastNearness(block);
  if (const float* drawn = cells.readCells(block)) {
    for (std::size_t i = 0; i < 64; ++i) to.cells[i] = std::max(drawn[i], least);
  } else {
    to.cells.fill(least);
  }
  const std::uint32_t columns = std::min(grid_.width - block_x * kBlockSide, kBlockSide);
  const std::uint32_t rows = std::min(grid_.height - block_y * kBlockSide, kBlockSide);
  if (columns < kBlockSide || rows < kBlockSide) {
    for (std::uint32_t i = 0; i < 64; ++i) {
      if (i % 8 >= columns || i / 8 >= rows) to.cells[i] = kPastTheRim;
    }
  }
  reduce(to.cells, 8, to.pairs);
  reduce(to.pairs, 4, to.quarters);
  writes_ += 21;
  return *std::min_element(to.quarters.begin(), to.quarters.end());
}

/// Propagates a block's value to coarser levels, until one does not change.
void DepthPyramid::raise(std::uint32_t x, std::uint32_t y, float value) {
  for (std::size_t i = 0;; ++i) {
    Level& level = levels_[i];
    float& here = level.values[std::size_t{y} * level.width + x];
    if (here == value) return;
    here = value;
    if (i != 0) ++writes_;
    if (kBlockLevel + i == top_) return;
    const std::uint32_t x0 = x & ~1U, y0 = y & ~1U;
    value = level.at(x0, y0);
    if (x0 + 1 < level.width) value = std::min(value, level.at(x0 + 1, y0));
    if (y0 + 1 < level.height) {
      value = std::min(value, level.at(x0, y0 + 1));
      if (x0 + 1 < level.width) value = std::min(value, level.at(x0 + 1, y0 + 1));
    }
    x /= 2;
    y /= 2;
  }
}

void DepthPyramid::updateTile(DepthCells& cells, std::uint32_t tile, std::uint64_t blocks) {
  const std::uint32_t left = tile % grid_.tiles_x * kTileSide;
  const std::uint32_t bottom = tile / grid_.tiles_x * kTileSide;
  for (; blocks != 0; blocks &= blocks - 1) {
    const auto bit = static_cast<std::uint32_t>(std::countr_zero(blocks));
    const std::uint32_t x = left + bit % kTileSide, y = bottom + bit / kTileSide;
    if (x < grid_.blocks_x && y < grid_.blocks_y) raise(x, y, refresh(cells, x, y));
  }
}

void DepthPyramid::update(DepthCells& cells, const CellRect& rect) {
  constexpr std::uint32_t kSide = kBlockSide * kTileSide;
  for (std::uint32_t y = rect.y0 / kSide; y <= rect.y1 / kSide; ++y) {
    for (std::uint32_t x = rect.x0 / kSide; x <= rect.x1 / kSide; ++x) {
      const std::uint32_t tile = y * grid_.tiles_x + x;
      updateTile(cells, tile, cells.takeRaised(tile));
    }
  }
}

void DepthPyramid::rebuild(DepthCells& cells) {
  for (std::uint32_t tile = 0; tile < grid_.tiles(); ++tile) {
    cells.takeRaised(tile);
    updateTile(cells, tile, ~std::uint64_t{0});
  }
}

float DepthPyramid::at(std::uint32_t level, std::uint32_t x, std::uint32_t y) const noexcept {
  if (level >= kBlockLevel) return levels_[level - kBlockLevel].at(x, y);
  const std::uint32_t shift = kBlockLevel - level, side = 1U << shift;
  const std::size_t index = std::size_t{y >> shift} * grid_.blocks_x + (x >> shift);
  if (raised_in_[index] != frame_) return 0.0F;
  const std::uint32_t within = (y & (side - 1)) * side + (x & (side - 1));
  const Block& block = blocks_[index];
  return level == 0 ? block.cells[within]
                    : (level == 1 ? block.pairs[within] : block.quarters[within]);
}

/// `nearest`: what is known of the box from the coarser cell. Taking the smaller of both makes
/// whatever a coarse cell hides hidden in all finer ones too.
bool DepthPyramid::hidesIn(const BoxProbe& probe, std::uint32_t level, std::uint32_t x,
                           std::uint32_t y, float nearest, OpenCell& open) {
  const CellRect cells{
      std::max(x << level, probe.rect.x0), std::min(((x + 1) << level) - 1, probe.rect.x1),
      std::max(y << level, probe.rect.y0), std::min(((y + 1) << level) - 1, probe.rect.y1)};
  if (cells.x0 > cells.x1 || cells.y0 > cells.y1 || probe.besides(cells)) return true;
  nearest = std::min(nearest, probe.nearestOver(cells));
  ++comparisons_;
  if (at(level, x, y) > nearest) return true;
  if (level == 0) {
    open = {x, y, nearest};
    return false;
  }
  for (std::uint32_t child = 0; child < 4; ++child) {
    if (!hidesIn(probe, level - 1, 2 * x + child % 2, 2 * y + child / 2, nearest, open))
      return false;
  }
  return true;
}

bool DepthPyramid::hides(const BoxProbe& probe, std::uint32_t levels, OpenCell& open) {
  const CellRect& r = probe.rect;
  const std::uint32_t most = std::min(levels, top_);
  std::uint32_t level = 0;
  while (level < most && (r.x0 >> level != r.x1 >> level || r.y0 >> level != r.y1 >> level))
    ++level;
  for (std::uint32_t y = r.y0 >> level; y <= r.y1 >> level; ++y) {
    for (std::uint32_t x = r.x0 >> level; x <= r.x1 >> level; ++x) {
      if (!hidesIn(probe, level, x, y, probe.nearest, open)) return false;
    }
  }
  return true;
}

}  // namespace culld
