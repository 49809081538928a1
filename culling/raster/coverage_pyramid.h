// The coverage pyramid of hierarchical polygon tiling (Greene 1996, "Hierarchical polygon tiling
// with coverage masks"): 8 x 8 masks over 8 x 8 masks, down to the cells. Where things are met
// front to back, whether a cell is covered is all that needs to be known. Each part of a node is
// covered, vacant or active (partly covered), and only active ones are looked into. Departs from
// it: a cell is covered if all of it is proven covered, not its sample.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "culling/raster/depth_cells.h"

namespace culld {

class CoveragePyramid {
 public:
  static constexpr std::uint32_t kAllLevels = 15;

  void reset(const CellGrid& grid);
  /// Takes over what `cells` says was raised in the tiles of `rect`, but for the cells of `except`:
  /// any nearness is coverage.
  void update(DepthCells& cells, const CellRect& rect, std::span<const CellRect> except = {});

  /// Is every cell of the rectangle covered? From the finest node that encloses it, no higher than
  /// `levels` above the blocks, down where parts of it are active.
  bool covers(const CellRect& rect, std::uint32_t levels);

  std::uint64_t masksCompared() const noexcept { return compared_; }  ///< since reset()

 private:
  /// Bit 8 * j + i: part (i, j). What is neither is vacant: nothing of it is covered.
  struct Node {
    std::uint64_t covered = 0, active = 0;
  };
  struct Level {
    std::uint32_t width = 0, height = 0;  ///< nodes
    std::vector<Node> nodes;
    Node& at(std::uint32_t x, std::uint32_t y) { return nodes[std::size_t{y} * width + x]; }
  };

  void setBlock(std::uint32_t block_x, std::uint32_t block_y, std::uint64_t covered);
  bool coversIn(std::size_t level, std::uint32_t x, std::uint32_t y, const CellRect& rect);

  CellGrid grid_;
  std::vector<Level> levels_;  ///< 0: nodes are blocks, parts are cells
  std::size_t used_levels_ = 0;
  std::uint64_t compared_ = 0;
};

}  // namespace culld
