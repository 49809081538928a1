// How far back the occluders of a frame reach, in a few large regions of the image: the depth half
// of the occlusion test with hierarchical occlusion maps (Zhang 1998, depth estimation buffer and
// no-background Z-buffer). docs/error-model/occlusion-map.md proves what it is good for.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/core/box.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/depth_cells.h"
#include "culling/raster/object_rows.h"

namespace culld {

inline constexpr std::uint32_t kMostDepthRegions = 256;  ///< per axis

class DepthEstimation {
 public:
  /// No occluder anywhere. REQUIRES: 1 <= regions <= kMostDepthRegions.
  void reset(const CellGrid& grid, std::uint32_t regions);

  /// An occluder within the rectangle of which no point is farther than `farthest`, a nearness.
  void add(const CellRect& rect, float farthest);
  /// All that was drawn, instead of add() for each occluder: as far as the covered cells reach.
  void addCells(DepthCells& cells);

  /// What is nowhere nearer than `nearest` lies behind all occluders in the rectangle's regions.
  bool behind(const CellRect& rect, float nearest) const;

 private:
  std::uint32_t column(std::uint32_t x) const noexcept { return x * regions_ / grid_.width; }
  std::uint32_t row(std::uint32_t y) const noexcept { return y * regions_ / grid_.height; }

  CellGrid grid_;
  std::uint32_t regions_ = 1;
  std::vector<float> farthest_;  ///< least nearness of any occluder there; infinite: none
};

/// A nearness that no point of an object's box falls below; 0 where there is none to be told.
/// `rows` made with a `largest` that holds for the box.
float farthestNearness(const ObjectRows& rows, const Box& bounds_mesh, bool perspective) noexcept;

}  // namespace culld
