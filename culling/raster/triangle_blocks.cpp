#include "culling/raster/triangle_blocks.h"

#include <algorithm>
#include <cmath>

#include "culling/raster/cell_view.h"
#include "culling/raster/rounding.h"

namespace culld {
namespace {

constexpr double kBlockCells = kBlockSide;
constexpr double kMaskMargin = 0x1p-12;  ///< cells; covers the float evaluation of masks (§4.3)

/// The value's least and largest deviation from the lower corner, over `cells` x `cells` cells.
double lowest(const SideLine& s, double cells) {
  return cells * (std::min(s.a, 0.0) + std::min(s.b, 0.0));
}
double highest(const SideLine& s, double cells) {
  return cells * (std::max(s.a, 0.0) + std::max(s.b, 0.0));
}

double atBlock(const SideLine& s, std::uint32_t block_x, std::uint32_t block_y) {
  return s.c + s.a * (kBlockCells * block_x) + s.b * (kBlockCells * block_y);
}

bool blockInside(const SideLine& s, std::uint32_t block_x, std::uint32_t block_y) {
  if (!s.usable()) return false;
  return atBlock(s, block_x, block_y) + lowest(s, kBlockCells) - (s.error + kMaskMargin) > 0.0;
}

bool blockBeside(const SideLine& s, std::uint32_t block_x, std::uint32_t block_y) {
  if (!s.usable()) return false;
  return atBlock(s, block_x, block_y) + highest(s, kBlockCells) + (s.error + kMaskMargin) < 0.0;
}

bool filled(const ProjectedTriangle& t, std::uint32_t block_x, std::uint32_t block_y) {
  for (std::uint32_t s = 0; s < t.side_count; ++s) {
    if (!blockInside(t.sides[s], block_x, block_y)) return false;
  }
  return true;
}

/// Where along a row a side's value, moved by `shift`, changes sign: first >= 0 for a rising side
/// (a > 0), last >= 0 for a falling one. Only a guess: callers widen or check it.
double crossing(const SideLine& s, std::uint32_t block_y, double shift) {
  return -(s.c + s.b * (kBlockCells * block_y) + shift) / (kBlockCells * s.a);
}

std::uint32_t clampBlock(double x, std::uint32_t low, std::uint32_t high) {
  return x > low ? static_cast<std::uint32_t>(std::min(x, static_cast<double>(high))) : low;
}

/// Narrows [first, end) to where side `s` may be touched; a block more on each side is harmless.
void narrowTouched(const SideLine& s, std::uint32_t block_y, std::uint32_t& first,
                   std::uint32_t& end) {
  if (!s.usable() || s.a == 0.0) return;
  const double x = crossing(s, block_y, highest(s, kBlockCells) + s.error + kMaskMargin);
  if (s.a > 0.0) first = std::max(first, clampBlock(x - 1.0, first, end));
  if (s.a < 0.0) end = std::min(end, clampBlock(x + 2.0, first, end));
}

/// Narrows [first, end) to about where side `s` leaves blocks inside.
void narrowFilled(const SideLine& s, std::uint32_t block_y, std::uint32_t& first,
                  std::uint32_t& end) {
  if (s.a == 0.0) {
    if (!blockInside(s, first, block_y)) end = first;
    return;
  }
  const double x = crossing(s, block_y, lowest(s, kBlockCells) - s.error - kMaskMargin);
  if (s.a > 0.0) first = std::max(first, clampBlock(std::floor(x) + 1.0, first, end));
  if (s.a < 0.0) end = std::min(end, clampBlock(std::ceil(x), first, end));
}

}  // namespace

BlockSpan blockSpan(const ProjectedTriangle& t, std::uint32_t block_y) noexcept {
  BlockSpan span;
  span.first_touched = t.cell_x0 / kBlockSide;
  span.end_touched = t.cell_x1 / kBlockSide + 1;
  for (std::uint32_t s = 0; s < t.side_count; ++s) {
    narrowTouched(t.sides[s], block_y, span.first_touched, span.end_touched);
  }
  std::uint32_t first = span.first_touched, end = span.end_touched;
  for (std::uint32_t s = 0; s < t.side_count; ++s) {
    if (!t.sides[s].usable()) end = first;
    narrowFilled(t.sides[s], block_y, first, end);
  }
  // Each side is linear along the row: if both ends are inside, so is everything between.
  while (first < end && !filled(t, first, block_y)) ++first;
  while (first < end && !filled(t, end - 1, block_y)) --end;
  span.first_filled = first;
  span.end_filled = std::max(first, end);
  return span;
}

float blockFarthest(const ProjectedTriangle& t, std::uint32_t block_x,
                    std::uint32_t block_y) noexcept {
  const double a = t.depth_a, b = t.depth_b;
  const double u0 = kBlockCells * block_x, v0 = kBlockCells * block_y;
  const double corner = t.depth_c + a * u0 + b * v0;
  const double far = corner + kBlockCells * (std::min(a, 0.0) + std::min(b, 0.0));
  const double terms =
      std::abs(t.depth_c) + std::abs(a) * (u0 + kBlockCells) + std::abs(b) * (v0 + kBlockCells);
  return floatDown(std::max(far - 0x1p-48 * terms, t.depth_floor));
}

std::optional<BlockTriangle> blockTriangle(const ProjectedTriangle& triangle, std::uint32_t block_x,
                                           std::uint32_t block_y,
                                           std::uint32_t net_edges) noexcept {
  BlockTriangle block;
  block.sides = 0;
  for (std::uint32_t s = 0; s < triangle.side_count; ++s) {
    const SideLine& side = triangle.sides[s];
    if (blockBeside(side, block_x, block_y)) return std::nullopt;
    if (blockInside(side, block_x, block_y)) continue;
    const std::uint32_t k = block.sides++;
    if (s >= 3 || (net_edges >> s & 1U) != 0) block.net_sides |= 1U << k;
    if (!side.usable()) {  // decides nothing: no cell inside, every cell touched
      block.a[k] = block.b[k] = block.c[k] = 0.0F;
      block.inside[k] = block.sample[k] = 1.0F;
      block.touch[k] = -1.0F;
      continue;
    }
    const double m = side.error + kMaskMargin;
    block.a[k] = static_cast<float>(side.a);
    block.b[k] = static_cast<float>(side.b);
    block.c[k] = static_cast<float>(atBlock(side, block_x, block_y));
    block.inside[k] = floatUp(m - lowest(side, 1.0));
    block.touch[k] = floatDown(-m - highest(side, 1.0));
    block.sample[k] = floatUp(m - side.a * kSampleX - side.b * kSampleY);
  }
  const double a = triangle.depth_a, b = triangle.depth_b;
  const double c = triangle.depth_c + a * (kBlockCells * block_x) + b * (kBlockCells * block_y) +
                   std::min(a, 0.0) + std::min(b, 0.0);
  const double slack = 0x1p-20 * (std::abs(c) + 8.0 * (std::abs(a) + std::abs(b))) + 1e-37;
  block.depth_floor = floatDown(triangle.depth_floor);
  if (std::abs(c) + 8.0 * (std::abs(a) + std::abs(b)) + slack < 1e37) {
    block.depth_a = static_cast<float>(a);
    block.depth_b = static_cast<float>(b);
    block.depth_c = floatDown(c - slack);
  } else {
    block.depth_c = block.depth_floor;
  }
  return block;
}

}  // namespace culld
