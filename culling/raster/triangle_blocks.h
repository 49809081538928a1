// A projected triangle as the blocks of 8 x 8 cells see it: which blocks of a row it may touch,
// which it fills, and the masks' input for those on its rim. docs/error-model.md §4.3.
#pragma once
#include <array>
#include <cstdint>

#include "culling/raster/coverage_kernels.h"
#include "culling/raster/triangle_setup.h"

namespace culld {

/// Blocks of one row, as half-open ranges; filled lies within touched.
struct BlockSpan {
  std::uint32_t first_touched = 0, end_touched = 0;
  std::uint32_t first_filled = 0, end_filled = 0;
};

class TriangleBlocks {
 public:
  /// `triangle` must outlive this. `net_edges`: bit e set if edge e is a net edge of its sheet;
  /// clip cuts always are.
  TriangleBlocks(const ProjectedTriangle& triangle, std::uint32_t net_edges) noexcept;

  /// REQUIRES: block_y within the triangle's cells. GUARANTEES: blocks outside `touched` are surely
  /// not touched by the triangle as it stands, blocks inside `filled` surely lie in it however it
  /// moves.
  BlockSpan span(std::uint32_t block_y) const noexcept;

  /// Nearness of the triangle's farthest point over the block, rounded farther.
  float farthest(std::uint32_t block_x, std::uint32_t block_y) const noexcept;
  /// What masks of this block will write is at most this near.
  float nearest(std::uint32_t block_x, std::uint32_t block_y) const noexcept;

  /// The triangle within one block: inside is what stays inside however it moves, all else is as it
  /// stands. False: it surely touches no cell of the block.
  bool part(std::uint32_t block_x, std::uint32_t block_y, BlockTriangle& out) const noexcept;

  /// For a triangle that moves. REQUIRES: block_y within what it reaches. `touched` only: a net
  /// edge surely comes to no other block.
  BlockSpan rimSpan(std::uint32_t block_y) const noexcept;
  /// Sides for rimCells(). False: no net edge comes to the block.
  bool rimPart(std::uint32_t block_x, std::uint32_t block_y, BlockTriangle& out) const noexcept;

 private:
  /// A side's line and thresholds in float, the same for all blocks.
  struct Masks {
    float a, b, inside, touch, sample;
    bool net;
  };

  const ProjectedTriangle& triangle_;
  std::array<Masks, kMaxSides> masks_;
  float depth_floor_;
};

}  // namespace culld
