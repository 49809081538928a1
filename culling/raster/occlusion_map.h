// What a frame's occluders cover together, as a pyramid of opacities (Zhang, Manocha, Hudson, Hoff
// 1997, hierarchical occlusion maps). A texel of level 0 stands for a block of 8 x 8 cells, one of
// level k + 1 for 2 x 2 of level k. Departs from it: a texel counts the cells that are *not* proven
// covered, exactly, where the source averages shades; and below level 0 the cells themselves are
// looked at. docs/error-model/occlusion-map.md.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/raster/cell_view.h"
#include "culling/raster/depth_cells.h"

namespace culld {

inline constexpr std::uint32_t kMostMapLevels = 8;  ///< beside level 0

/// Of a texel of level 0: 1 - (cells that may stay open) / 64. The thresholds of the levels above
/// follow, O[k + 1] = (3 + O[k]) / 4: the same number of cells in every one.
std::uint32_t negligibleHole(double opacity) noexcept;

struct OverlapRules {
  std::uint32_t hole = 0;  ///< cells of a texel that may stay open; 0: nothing may
  /// A texel that is open to at least this share is taken to fail without looking closer. Only a
  /// wholly open one surely does; less keeps more.
  double give_up = 1.0;
};

struct Overlap {
  bool covered = false;
  std::uint32_t texels = 0;  ///< looked at
};

class OcclusionMap {
 public:
  /// `levels` beside level 0, fewer if one texel is enough. COST: about 10 ns a block.
  void build(DepthCells& cells, std::uint32_t levels);

  /// Begins at the level whose texels are about as large as the rectangle, and goes on to finer
  /// ones where a texel does not settle it. GUARANTEES: with hole = 0, covered means that every
  /// cell of the rectangle is proven covered. REQUIRES: the rectangle within the grid.
  Overlap overlap(const CellRect& rect, const OverlapRules& rules) const;

  std::uint32_t levels() const noexcept { return static_cast<std::uint32_t>(levels_.size()) - 1; }
  const CellGrid& grid() const noexcept { return grid_; }
  /// Share of the texel's cells on the grid that are covered.
  double opacity(std::uint32_t level, std::uint32_t x, std::uint32_t y) const noexcept;
  /// The block's cells that are not proven covered and on the grid, bit 8 * j + i for (i, j).
  std::uint64_t openCells(std::uint32_t block_x, std::uint32_t block_y) const noexcept {
    return open_[std::size_t{block_y} * grid_.blocks_x + block_x];
  }

 private:
  struct Level {
    std::uint32_t width = 0, height = 0;
    std::vector<std::uint32_t> open;  ///< cells
    std::uint32_t at(std::uint32_t x, std::uint32_t y) const noexcept {
      return open[std::size_t{y} * width + x];
    }
  };
  struct Query {
    CellRect rect;
    OverlapRules rules;
    std::uint32_t texels;
  };
  void addLevel();
  CellRect cellsOf(std::uint32_t level, std::uint32_t x, std::uint32_t y) const noexcept;
  bool texelCovered(std::uint32_t level, std::uint32_t x, std::uint32_t y, Query& query) const;

  CellGrid grid_;
  std::vector<std::uint64_t> open_;  ///< by block, row by row
  std::vector<Level> levels_;
};

}  // namespace culld
