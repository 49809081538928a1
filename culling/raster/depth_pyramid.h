// The Z-pyramid of hierarchical visibility (Greene, Kass, Miller 1993): over a Z-buffer, levels of
// which each value is the farthest of a 2 x 2 window of the level below, kept up to date whenever a
// depth is written. Here the Z-buffer is DepthCells, so a value is a nearness that every ray
// through the cell meets, and the farthest is the least.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "culling/raster/box_probe.h"
#include "culling/raster/depth_cells.h"

namespace culld {

/// A cell in which something asked for may be seen, and how near it may be there.
struct OpenCell {
  std::uint32_t x = 0, y = 0;
  float nearest = 0.0F;
};

class DepthPyramid {
 public:
  /// Levels above the Z-buffer that are used: 0 leaves the Z-buffer alone.
  static constexpr std::uint32_t kAllLevels = 31;

  /// Forgets everything. COST: one float per 8 x 8 cells.
  void reset(const CellGrid& grid);

  /// Takes over what `cells` says was raised in the tiles of `rect`, level by level until nothing
  /// changes.
  void update(DepthCells& cells, const CellRect& rect);
  /// The same for the whole image, whatever was raised: what keeping it up to date saves.
  void rebuild(DepthCells& cells);

  /// True if the box is hidden in every cell that it may be on: each holds something strictly
  /// nearer. From the finest cell that encloses the box's rectangle, no higher than `levels`, down
  /// to finer cells where needed. If false, `open` is one of the cells that do not hide it.
  /// GUARANTEES: the answer depends on the cells alone, not on how they came about, and more
  /// nearness in cells never makes hidden things open.
  bool hides(const BoxProbe& probe, std::uint32_t levels, OpenCell& open);
  /// Does the cell still not hide it?
  bool stillOpen(const OpenCell& open) const noexcept {
    return !(at(0, open.x, open.y) > open.nearest);
  }

  /// Level 0 are the cells. REQUIRES: a cell of that level. COST: O(1).
  float at(std::uint32_t level, std::uint32_t x, std::uint32_t y) const noexcept;
  std::uint32_t topLevel() const noexcept { return top_; }

  std::uint64_t comparisons() const noexcept { return comparisons_; }  ///< depths, since reset()
  std::uint64_t writes() const noexcept { return writes_; }  ///< values above the cells, the same

 private:
  static constexpr std::uint32_t kBlockLevel = 3;

  /// The levels within one block; valid if it was raised since reset().
  struct Block {
    std::array<float, 64> cells;
    std::array<float, 16> pairs;
    std::array<float, 4> quarters;
  };
  /// One level from the blocks on.
  struct Level {
    std::uint32_t width = 0, height = 0;
    std::vector<float> values;
    float at(std::uint32_t x, std::uint32_t y) const noexcept {
      return values[std::size_t{y} * width + x];
    }
  };

  void updateTile(DepthCells& cells, std::uint32_t tile, std::uint64_t blocks);
  float refresh(const DepthCells& cells, std::uint32_t block_x, std::uint32_t block_y);
  void raise(std::uint32_t block_x, std::uint32_t block_y, float value);
  bool hidesIn(const BoxProbe& probe, std::uint32_t level, std::uint32_t x, std::uint32_t y,
               float nearest, OpenCell& open);

  CellGrid grid_;
  std::uint32_t top_ = 0;
  std::vector<Level> levels_;             ///< from kBlockLevel on
  std::vector<Block> blocks_;             ///< row by row
  std::vector<std::uint32_t> raised_in_;  ///< frame in which the block was raised
  std::uint32_t frame_ = 0;
  std::uint64_t comparisons_ = 0, writes_ = 0;
};

}  // namespace culld
