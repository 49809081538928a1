#include <algorithm>

#include "culling/raster/outline_kernels.h"

namespace culld {
namespace {

float valueAt(float a, float b, float c, std::uint32_t part) {
  const std::uint32_t column = part % 8, row = part / 8;
  return a * static_cast<float>(column) + (c + b * static_cast<float>(row));
}

}  // namespace

std::uint64_t outlineInsideReference(const OutlineSquare& square) {
  std::uint64_t inside = ~std::uint64_t{0};
  for (std::uint32_t s = 0; s < square.sides; ++s) {
    for (std::uint32_t part = 0; part < 64; ++part) {
      const float value = valueAt(square.a[s], square.b[s], square.c[s], part);
      if (!(value >= square.full[s])) inside &= ~(std::uint64_t{1} << part);
    }
  }
  return inside;
}

void outlineMasksReference(const OutlineSquare& square, const float* nearness,
                           OutlineMasks& masks) {
  masks.full = masks.some = ~std::uint64_t{0};
  for (std::uint32_t s = 0; s < square.sides; ++s) {
    std::uint64_t full = 0, some = 0;
    for (std::uint32_t part = 0; part < 64; ++part) {
      const float value = valueAt(square.a[s], square.b[s], square.c[s], part);
      if (value >= square.full[s]) full |= std::uint64_t{1} << part;
      if (value >= square.some[s]) some |= std::uint64_t{1} << part;
    }
    masks.full_of_side[s] = full;
    masks.full &= full;
    masks.some &= some;
  }
  masks.raisable = 0;
  for (std::uint32_t part = 0; part < 64; ++part) {
    float top = square.depth_ceiling;
    for (std::uint32_t p = 0; p < square.planes; ++p) {
      top = std::min(top, valueAt(square.plane_a[p], square.plane_b[p], square.plane_c[p], part) +
                              square.plane_rise[p]);
    }
    if (std::max(top, square.depth_floor) > nearness[part])
      masks.raisable |= std::uint64_t{1} << part;
  }
}

float raiseOutlineReference(const OutlineSquare& square, std::uint64_t covered, float* nearness) {
  float least = 3.0e38F;
  for (std::uint32_t part = 0; part < 64; ++part) {
    float depth = 3.0e38F;
    for (std::uint32_t p = 0; p < square.planes; ++p) {
      depth =
          std::min(depth, valueAt(square.plane_a[p], square.plane_b[p], square.plane_c[p], part));
    }
    depth = std::max(depth, square.depth_floor);
    if ((covered >> part & 1U) != 0) nearness[part] = std::max(nearness[part], depth);
    least = std::min(least, nearness[part]);
  }
  return least;
}

}  // namespace culld
