// From the rectangles of eight projected boxes to closed ranges of cells.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "culling/raster/box_kernels.h"
#include "culling/raster/depth_cells.h"

namespace culld {

inline std::uint32_t clampCell(float x, std::uint32_t side) noexcept {
  const float top = static_cast<float>(side - 1);
  return static_cast<std::uint32_t>(std::min(std::max(x, 0.0F), top));  // truncation: x >= 0
}

/// The cells that box `lane` may be on; of one beside the grid the nearest ones.
inline CellRect cellRect(const BoxRects& rects, std::size_t lane, const CellGrid& grid) noexcept {
  return {clampCell(rects.x0[lane], grid.width), clampCell(rects.x1[lane], grid.width),
          clampCell(rects.y0[lane], grid.height), clampCell(rects.y1[lane], grid.height)};
}

/// The whole grid.
inline CellRect everyCell(const CellGrid& grid) noexcept {
  return {0, grid.width - 1, 0, grid.height - 1};
}

}  // namespace culld
