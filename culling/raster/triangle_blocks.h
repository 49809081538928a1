// A projected triangle as the blocks of 8 x 8 cells see it: which blocks of a row it may touch,
// which it fills, and the masks' input for those on its rim. docs/error-model.md §4.3.
#pragma once
#include <cstdint>
#include <optional>

#include "culling/raster/coverage_kernels.h"
#include "culling/raster/triangle_setup.h"

namespace culld {

/// Blocks of one row, as half-open ranges; filled lies within touched.
struct BlockSpan {
  std::uint32_t first_touched = 0, end_touched = 0;
  std::uint32_t first_filled = 0, end_filled = 0;
};

/// REQUIRES: triangle.on_grid and block_y within its cells. GUARANTEES: blocks outside `touched`
/// are surely not touched, blocks inside `filled` surely lie in the triangle.
BlockSpan blockSpan(const ProjectedTriangle& triangle, std::uint32_t block_y) noexcept;

/// Nearness of a farthest point of the triangle over the block, rounded farther.
float blockFarthest(const ProjectedTriangle& triangle, std::uint32_t block_x,
                    std::uint32_t block_y) noexcept;

/// The triangle as block (block_x, block_y) sees it. `net_edges`: bit e set if edge e is a net edge
/// of its sheet; clip cuts always are. nullopt: it surely touches no cell of the block.
std::optional<BlockTriangle> blockTriangle(const ProjectedTriangle& triangle, std::uint32_t block_x,
                                           std::uint32_t block_y, std::uint32_t net_edges) noexcept;

}  // namespace culld
