// The scalar truth of coverage_kernels.h: short, obvious, and in the same order of operations.
#include <algorithm>

#include "culling/raster/coverage_kernels.h"

namespace culld {

void addTriangleReference(const BlockTriangle& t, SheetBlock& sheet, float* nearness) {
  for (std::uint32_t j = 0; j < 8; ++j) {
    for (std::uint32_t i = 0; i < 8; ++i) {
      bool inside = true, touched = true, sampled = true, rim = false;
      for (std::uint32_t s = 0; s < t.sides; ++s) {
        const float row = t.c[s] + t.b[s] * static_cast<float>(j);
        const float value = t.a[s] * static_cast<float>(i) + row;
        const bool side_inside = value >= t.inside[s];
        inside = inside && side_inside;
        touched = touched && value >= t.touch[s];
        sampled = sampled && value >= t.sample[s];
        rim = rim || ((t.net_sides >> s & 1U) != 0 && !side_inside);
      }
      if (!touched) continue;
      const std::uint64_t bit = std::uint64_t{1} << (8 * j + i);
      const float plane_row = t.depth_c + t.depth_b * static_cast<float>(j);
      const float depth = std::max(t.depth_a * static_cast<float>(i) + plane_row, t.depth_floor);
      const std::uint32_t cell = 8 * j + i;
      sheet.farthest[cell] = std::min(sheet.farthest[cell], depth);
      if (rim) sheet.rim |= bit;
      if (sampled) sheet.sampled |= bit;
      if (!inside) continue;
      nearness[cell] = std::max(nearness[cell], depth);
    }
  }
}

std::uint64_t rimCellsReference(const BlockTriangle& t) {
  std::uint64_t rim = 0;
  for (std::uint32_t cell = 0; cell < 64; ++cell) {
    const std::uint32_t i = cell % 8, j = cell / 8;
    bool touched = true, on_rim = false;
    for (std::uint32_t s = 0; s < t.sides; ++s) {
      const float row = t.c[s] + t.b[s] * static_cast<float>(j);
      const float value = t.a[s] * static_cast<float>(i) + row;
      touched = touched && value >= t.touch[s];
      on_rim = on_rim || ((t.net_sides >> s & 1U) != 0 && !(value >= t.inside[s]));
    }
    if (touched && on_rim) rim |= std::uint64_t{1} << cell;
  }
  return rim;
}

float raiseCellsReference(std::uint64_t covered, const float* farthest, float* nearness) {
  float least = 3.0e38F;
  for (std::uint32_t cell = 0; cell < 64; ++cell) {
    if (covered >> cell & 1U) nearness[cell] = std::max(nearness[cell], farthest[cell]);
    least = std::min(least, nearness[cell]);
  }
  return least;
}

std::uint64_t cellsNearerThanReference(const float* nearness, float limit) {
  std::uint64_t mask = 0;
  for (std::uint32_t cell = 0; cell < 64; ++cell) {
    if (nearness[cell] > limit) mask |= std::uint64_t{1} << cell;
  }
  return mask;
}

}  // namespace culld
