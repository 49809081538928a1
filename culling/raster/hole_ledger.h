// Which open cells have been taken for covered so far: a bound on the pixels that an approximate
// answer may lose, kept below what was accepted. docs/error-model/occlusion-map.md.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/raster/occlusion_map.h"

namespace culld {

class HoleLedger {
 public:
  /// `accepted_px`: pixels of an image of `image_px` that may be lost. REQUIRES: a finite, built
  /// map, which outlives the frame.
  void reset(const OcclusionMap& map, double image_px, double accepted_px);

  /// Takes the open cells of the rectangle for covered. False, and nothing is taken, if more would
  /// be lost than was accepted. COST: a few ns per block.
  bool take(const CellRect& rect);

  /// At least as many pixels as all cells taken have.
  double lostPx() const noexcept { return static_cast<double>(taken_) * cell_px_; }

 private:
  const OcclusionMap* map_ = nullptr;
  double cell_px_ = 0.0, accepted_px_ = 0.0;
  std::uint64_t taken_ = 0;              ///< cells, each counted once
  std::vector<std::uint64_t> cells_of_;  ///< by block, row by row
};

}  // namespace culld
