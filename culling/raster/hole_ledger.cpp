#include "culling/raster/hole_ledger.h"

#include <bit>

namespace culld {

void HoleLedger::reset(const OcclusionMap& map, double image_px, double accepted_px) {
  const CellGrid& grid = map.grid();
  map_ = &map;
  cell_px_ = image_px / (static_cast<double>(grid.width) * static_cast<double>(grid.height));
  accepted_px_ = accepted_px;
  taken_ = 0;
  cells_of_.assign(std::size_t{grid.blocks_x} * grid.blocks_y, 0);
}

bool HoleLedger::take(const CellRect& rect) {
  const std::uint32_t x0 = rect.x0 / kBlockSide, x1 = rect.x1 / kBlockSide;
  const std::uint32_t y0 = rect.y0 / kBlockSide, y1 = rect.y1 / kBlockSide;
  const std::size_t stride = map_->grid().blocks_x;
  const auto fresh = [&](std::uint32_t x, std::uint32_t y) {
    const std::uint64_t under = squareMask(rect, x * kBlockSide, y * kBlockSide);
    return map_->openCells(x, y) & under & ~cells_of_[y * stride + x];
  };
  std::uint64_t more = 0;
  for (std::uint32_t y = y0; y <= y1; ++y) {
    for (std::uint32_t x = x0; x <= x1; ++x) {
      more += static_cast<std::uint64_t>(std::popcount(fresh(x, y)));
    }
  }
  if (!(static_cast<double>(taken_ + more) * cell_px_ <= accepted_px_)) return false;
  taken_ += more;
  if (more == 0) return true;
  for (std::uint32_t y = y0; y <= y1; ++y) {
    for (std::uint32_t x = x0; x <= x1; ++x) cells_of_[y * stride + x] |= fresh(x, y);
  }
  return true;
}

}  // namespace culld
