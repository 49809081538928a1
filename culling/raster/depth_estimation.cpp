#include "culling/raster/depth_estimation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "culling/raster/rounding.h"

namespace culld {
namespace {

constexpr float kNone = std::numeric_limits<float>::infinity();

/// No covered cell of the block is farther; infinite if none is covered.
float farthestOf(const DepthCells& cells, std::uint32_t block) {
  const float least = cells.leastNearness(block);
  if (least > 0.0F) return least;
  const float* c = cells.readCells(block);
  if (c == nullptr) return kNone;
  float farthest = kNone;
  for (std::uint32_t i = 0; i < kBlockSide * kBlockSide; ++i) {
    farthest = std::min(farthest, c[i] > 0.0F ? c[i] : kNone);
  }
  return farthest;
}

}  // namespace

void DepthEstimation::reset(const CellGrid& grid, std::uint32_t regions) {
  grid_ = grid;
  regions_ = regions;
  farthest_.assign(std::size_t{regions} * regions, kNone);
}

void DepthEstimation::add(const CellRect& rect, float farthest) {
  const std::uint32_t x0 = column(rect.x0), x1 = column(rect.x1), y1 = row(rect.y1);
  for (std::uint32_t y = row(rect.y0); y <= y1; ++y) {
    float* line = farthest_.data() + std::size_t{y} * regions_;
    for (std::uint32_t x = x0; x <= x1; ++x) line[x] = std::min(line[x], farthest);
  }
}

void DepthEstimation::addCells(DepthCells& cells) {
  for (std::uint32_t y = 0; y < grid_.blocks_y; ++y) {
    for (std::uint32_t x = 0; x < grid_.blocks_x; ++x) {
      const float farthest = farthestOf(cells, grid_.blockAt(x, y));
      if (farthest == kNone) continue;
      const std::uint32_t left = x * kBlockSide, bottom = y * kBlockSide;
      add({left, std::min(left + kBlockSide, grid_.width) - 1, bottom,
           std::min(bottom + kBlockSide, grid_.height) - 1},
          farthest);
    }
  }
}

bool DepthEstimation::behind(const CellRect& rect, float nearest) const {
  const std::uint32_t x0 = column(rect.x0), x1 = column(rect.x1), y1 = row(rect.y1);
  for (std::uint32_t y = row(rect.y0); y <= y1; ++y) {
    const float* line = farthest_.data() + std::size_t{y} * regions_;
    for (std::uint32_t x = x0; x <= x1; ++x) {
      if (!(line[x] > nearest)) return false;
    }
  }
  return true;
}

/// A linear function is least, or largest, at a corner; with the error of a vertex that is it.
float farthestNearness(const ObjectRows& rows, const Box& bounds_mesh, bool perspective) noexcept {
  double extreme = -std::numeric_limits<double>::infinity();
  for (int i = 0; i < 8; ++i) {
    const glm::dvec3 corner((i & 1) != 0 ? bounds_mesh.max.x : bounds_mesh.min.x,
                            (i & 2) != 0 ? bounds_mesh.max.y : bounds_mesh.min.y,
                            (i & 4) != 0 ? bounds_mesh.max.z : bounds_mesh.min.z);
    const double value = perspective ? rows.w.at(corner) : -rows.n.at(corner);
    if (!(value <= extreme)) extreme = value;  // NaN stays
    if (std::isnan(value)) return 0.0F;
  }
  if (!perspective) {
    const double nearness = -extreme - 2.0 * rows.error.n;
    return nearness > 0.0 ? floatDown(nearness) : 0.0F;
  }
  const double farthest_w = extreme + 2.0 * rows.error.w;
  if (!(farthest_w > 0.0)) return 0.0F;
  return floatDown((1.0 - 0x1p-40) / farthest_w);
}

}  // namespace culld
