#include "culling/raster/coverage_pyramid.h"

#include <algorithm>
#include <bit>

#include "culling/raster/coverage_kernels.h"

namespace culld {
namespace {

constexpr std::uint64_t kAll = ~std::uint64_t{0};
constexpr std::uint32_t kPartBits = 3;  ///< 8 parts along each axis

/// The parts of node (x, y) that do not exist: past the last of `width` x `height`.
std::uint64_t missingParts(std::uint32_t x, std::uint32_t y, std::uint32_t width,
                           std::uint32_t height) {
  const CellRect there{0, width - 1, 0, height - 1};
  return ~squareMask(there, 8 * x, 8 * y);
}

/// The cells of the block at (x, y) that are in one of the rectangles.
std::uint64_t cellsOf(std::span<const CellRect> rects, std::uint32_t x, std::uint32_t y) {
  std::uint64_t cells = 0;
  for (const CellRect& r : rects) {
    const bool meets = r.x0 < x + 8 && r.x1 >= x && r.y0 < y + 8 && r.y1 >= y;
    if (meets) cells |= squareMask(r, x, y);
  }
  return cells;
}

}  // namespace

void CoveragePyramid::reset(const CellGrid& grid) {
  grid_ = grid;
  compared_ = 0;
  used_levels_ = 0;
  std::uint32_t parts_x = grid.width, parts_y = grid.height;
  do {
    if (levels_.size() == used_levels_) levels_.emplace_back();
    Level& level = levels_[used_levels_++];
    level.width = (parts_x + 7) / 8;
    level.height = (parts_y + 7) / 8;
    level.nodes.assign(std::size_t{level.width} * level.height, Node{});
    // Nothing is seen past the image's rim: it counts as covered.
    for (std::uint32_t y = 0; y < level.height; ++y) {
      for (std::uint32_t x = 0; x < level.width; ++x) {
        if (x + 1 < level.width && y + 1 < level.height) continue;
        level.at(x, y).covered = missingParts(x, y, parts_x, parts_y);
      }
    }
    parts_x = level.width;
    parts_y = level.height;
  } while (parts_x > 1 || parts_y > 1);
}

/// Tells coarser nodes as far as anything changes for them.
void CoveragePyramid::setBlock(std::uint32_t x, std::uint32_t y, std::uint64_t covered) {
  Node& block = levels_[0].at(x, y);
  if (block.covered == (block.covered | covered)) return;
  block.covered |= covered;
  bool full = block.covered == kAll;
  for (std::size_t i = 1; i < used_levels_; ++i) {
    Node& above = levels_[i].at(x >> kPartBits, y >> kPartBits);
    const std::uint64_t bit = std::uint64_t{1} << (8 * (y & 7U) + (x & 7U));
    if (((full ? above.covered : above.active) & bit) != 0) return;
    above.active = full ? above.active & ~bit : above.active | bit;
    if (full) above.covered |= bit;
    full = above.covered == kAll;
    x >>= kPartBits;
    y >>= kPartBits;
  }
}

void CoveragePyramid::update(DepthCells& cells, const CellRect& rect,
                             std::span<const CellRect> except) {
  constexpr std::uint32_t kSide = kBlockSide * kTileSide;
  for (std::uint32_t ty = rect.y0 / kSide; ty <= rect.y1 / kSide; ++ty) {
    for (std::uint32_t tx = rect.x0 / kSide; tx <= rect.x1 / kSide; ++tx) {
      std::uint64_t raised = cells.takeRaised(ty * grid_.tiles_x + tx);
      for (; raised != 0; raised &= raised - 1) {
        const auto bit = static_cast<std::uint32_t>(std::countr_zero(raised));
        const std::uint32_t x = tx * kTileSide + bit % 8, y = ty * kTileSide + bit / 8;
        if (x >= grid_.blocks_x || y >= grid_.blocks_y) continue;
        const std::uint32_t block = grid_.blockAt(x, y);
        const float* drawn = cells.readCells(block);
        const std::uint64_t covered = cells.leastNearness(block) > 0.0F ? kAll
                                      : drawn == nullptr                ? 0
                                                         : cellsNearerThan(drawn, 0.0F);
        setBlock(x, y, covered & ~cellsOf(except, x * kBlockSide, y * kBlockSide));
      }
    }
  }
}

bool CoveragePyramid::coversIn(std::size_t level, std::uint32_t x, std::uint32_t y,
                               const CellRect& rect) {
  const auto shift = static_cast<std::uint32_t>(kPartBits * level);
  const CellRect parts{rect.x0 >> shift, rect.x1 >> shift, rect.y0 >> shift, rect.y1 >> shift};
  const Node& node = levels_[level].at(x, y);
  ++compared_;
  std::uint64_t open = squareMask(parts, 8 * x, 8 * y) & ~node.covered;
  if (open == 0) return true;
  if (level == 0 || (open & ~node.active) != 0) return false;  // a vacant part is open
  for (; open != 0; open &= open - 1) {
    const auto bit = static_cast<std::uint32_t>(std::countr_zero(open));
    if (!coversIn(level - 1, 8 * x + bit % 8, 8 * y + bit / 8, rect)) return false;
  }
  return true;
}

bool CoveragePyramid::covers(const CellRect& r, std::uint32_t levels) {
  const std::size_t most = std::min<std::size_t>(levels, used_levels_ - 1);
  std::size_t level = 0;
  std::uint32_t shift = kPartBits;
  for (; level < most && (r.x0 >> shift != r.x1 >> shift || r.y0 >> shift != r.y1 >> shift);
       shift += kPartBits) {
    ++level;
  }
  for (std::uint32_t y = r.y0 >> shift; y <= r.y1 >> shift; ++y) {
    for (std::uint32_t x = r.x0 >> shift; x <= r.x1 >> shift; ++x) {
      if (!coversIn(level, x, y, r)) return false;
    }
  }
  return true;
}

}  // namespace culld
