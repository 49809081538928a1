// What the occluders drawn so far prove: per cell a nearness such that every ray through the cell
// meets a blocking surface at least that near. 0 means nothing is proven. A block's own nearness
// holds for all its cells, whatever theirs says.
#pragma once
#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "culling/raster/cell_view.h"

namespace culld {

/// A closed range of cells.
struct CellRect {
  std::uint32_t x0, x1, y0, y1;
  /// 0 if ends are the wrong way around.
  std::uint64_t cells() const noexcept {
    if (x1 < x0 || y1 < y0) return 0;
    return std::uint64_t{x1 - x0 + 1} * (y1 - y0 + 1);
  }
};

/// Bits of the 8 x 8 square whose lower corner is (x, y): those within `rect`, in the same units.
/// Bit 8 * j + i stands for (x + i, y + j). REQUIRES: they meet.
std::uint64_t squareMask(const CellRect& rect, std::uint32_t x, std::uint32_t y) noexcept;

class DepthCells {
 public:
  /// Forgets everything. COST: one float per block; cells are cleared when first used.
  void reset(const CellGrid& grid);

  const CellGrid& grid() const noexcept { return grid_; }
  /// The block's 64 cells, cell (i, j) at 8 * j + i, to be raised.
  float* cells(std::uint32_t block);
  /// The same to be read; nullptr if nothing was raised there since reset().
  const float* readCells(std::uint32_t block) const noexcept {
    return used(block) ? cells_[block].data() : nullptr;
  }
  /// True if cells() was called for the block since reset().
  bool used(std::uint32_t block) const noexcept { return used_in_[block] == frame_; }
  /// Every cell of the block is at least this near.
  float leastNearness(std::uint32_t block) const noexcept { return least_[block]; }
  void setLeastNearness(std::uint32_t block, float least) noexcept {
    least_[block] = least;
    forgetLeastOfTile(block / (kTileSide * kTileSide));
    markRaised(block);
  }

  /// leastNearness of the 64 blocks of a tile, to be raised; then the tile's own is to be told, and
  /// which blocks were.
  float* leastOfBlocks(std::uint32_t tile) noexcept {
    return least_.data() + std::size_t{tile} * kTileSide * kTileSide;
  }
  /// Every block of the tile is at least this near; not always the most that is known.
  float leastOfTile(std::uint32_t tile) const noexcept { return tile_least_[tile]; }
  void setLeastOfTile(std::uint32_t tile, float least) noexcept {
    tile_least_[tile] = least;
    tile_stale_[tile] = 0;
  }
  void forgetLeastOfTile(std::uint32_t tile) noexcept { tile_stale_[tile] = 1; }
  void markBlocksRaised(std::uint32_t tile, std::uint64_t blocks) noexcept {
    raised_[tile] |= blocks;
  }

  /// The blocks of a tile in which something may have been raised since this was last asked, for
  /// what is kept up to date beside the cells. Bit 8 * j + i: block (i, j) of the tile.
  std::uint64_t takeRaised(std::uint32_t tile) noexcept {
    return std::exchange(raised_[tile], std::uint64_t{0});
  }

  /// Something in the rectangle, nowhere nearer than `nearest`, is hidden in every cell of it.
  /// Cells at the same nearness do not hide.
  bool certainlyHidden(const CellRect& rect, float nearest);

  std::size_t bytes() const noexcept;

 private:
  void markRaised(std::uint32_t block) noexcept {
    raised_[block / (kTileSide * kTileSide)] |= std::uint64_t{1} << block % (kTileSide * kTileSide);
  }
  void hidePastTheRim(std::uint32_t block);
  bool cellsHide(std::uint32_t block_x, std::uint32_t block_y, const CellRect& rect,
                 float nearest) const;
  bool tileHides(std::uint32_t tile_x, std::uint32_t tile_y, const CellRect& rect, float nearest);

  CellGrid grid_;
  std::vector<float> least_;       ///< by block
  std::vector<float> tile_least_;  ///< least of a tile's blocks, or less if stale
  std::vector<std::uint8_t> tile_stale_;
  std::vector<std::uint64_t> raised_;  ///< by tile
  std::vector<std::array<float, 64>> cells_;
  std::vector<std::uint32_t> used_in_;  ///< frame in which the block's cells were last cleared
  std::uint32_t frame_ = 0;
};

}  // namespace culld
