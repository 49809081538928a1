#include "culling/raster/triangle_blocks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "culling/raster/cell_view.h"
#include "culling/raster/rounding.h"

namespace culld {
namespace {

constexpr double kBlockCells = kBlockSide;
constexpr double kMaskMargin = 0x1p-12;  ///< cells; covers the float evaluation of masks (§4.3)
constexpr double kMostSway = 512.0;      ///< cells up to which it does so

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

/// How far a side may move within a block, cells; convex along a row. 0 if it stands still.
double swayIn(const SideLine& s, std::uint32_t block_x, std::uint32_t block_y) {
  const double corner =
      s.sway_c + s.sway_a * (kBlockCells * block_x) + s.sway_b * (kBlockCells * block_y);
  return std::max(corner + kBlockCells * (std::max(s.sway_a, 0.0) + std::max(s.sway_b, 0.0)), 0.0);
}

/// `sway`: how far the side may move; the block is inside all the same.
bool blockInside(const SideLine& s, std::uint32_t block_x, std::uint32_t block_y, double sway) {
  if (!s.usable()) return false;
  const double margin = s.error + kMaskMargin + sway;
  return atBlock(s, block_x, block_y) + lowest(s, kBlockCells) - margin > 0.0;
}

/// As blockInside.
bool blockBeside(const SideLine& s, std::uint32_t block_x, std::uint32_t block_y, double sway) {
  if (!s.usable()) return false;
  const double margin = s.error + kMaskMargin + sway;
  return atBlock(s, block_x, block_y) + highest(s, kBlockCells) + margin < 0.0;
}

bool filled(const ProjectedTriangle& t, std::uint32_t block_x, std::uint32_t block_y) {
  for (std::uint32_t s = 0; s < t.side_count; ++s) {
    const double sway = t.moving ? swayIn(t.sides[s], block_x, block_y) : 0.0;
    if (!blockInside(t.sides[s], block_x, block_y, sway)) return false;
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
/// `sway`: as in blockBeside.
void narrowTouched(const SideLine& s, std::uint32_t block_y, double sway, std::uint32_t& first,
                   std::uint32_t& end) {
  if (!s.usable() || s.a == 0.0) return;
  const double margin = s.error + kMaskMargin + sway;
  const double x = crossing(s, block_y, highest(s, kBlockCells) + margin);
  if (s.a > 0.0) first = std::max(first, clampBlock(x - 1.0, first, end));
  if (s.a < 0.0) end = std::min(end, clampBlock(x + 2.0, first, end));
}

/// The side moved inwards by its sway, as if that were linear everywhere.
SideLine swayedInwards(const SideLine& s) {
  const double most = kBlockCells * (std::max(s.sway_a, 0.0) + std::max(s.sway_b, 0.0));
  return {s.a - s.sway_a, s.b - s.sway_b, s.c - (s.sway_c + most), s.error};
}

/// Narrows [first, end) to about where side `s` leaves blocks inside.
void narrowFilled(const SideLine& s, std::uint32_t block_y, std::uint32_t& first,
                  std::uint32_t& end) {
  if (s.a == 0.0) {
    if (!blockInside(s, first, block_y, 0.0)) end = first;
    return;
  }
  const double x = crossing(s, block_y, lowest(s, kBlockCells) - s.error - kMaskMargin);
  if (s.a > 0.0) first = std::max(first, clampBlock(std::floor(x) + 1.0, first, end));
  if (s.a < 0.0) end = std::min(end, clampBlock(std::ceil(x), first, end));
}

/// Side `k` is to hold cells however it moves.
void addSway(double sway, BlockTriangle& out, std::uint32_t k) {
  if (sway <= kMostSway) {
    out.inside[k] += static_cast<float>(sway);  // kMaskMargin covers the rounding
  } else {  // no cell is inside, and of the value only the sign matters
    out.inside[k] = std::numeric_limits<float>::max();
    out.c[k] = std::clamp(out.c[k], -64.0F, 64.0F);
  }
}

}  // namespace

TriangleBlocks::TriangleBlocks(const ProjectedTriangle& triangle, std::uint32_t net_edges) noexcept
    : triangle_(triangle), depth_floor_(floatDown(triangle.depth_floor)) {
  for (std::uint32_t s = 0; s < triangle.side_count; ++s) {
    const SideLine& side = triangle.sides[s];
    Masks& m = masks_[s];
    m.net = s >= 3 || (net_edges >> s & 1U) != 0;
    if (side.usable()) {
      const double margin = side.error + kMaskMargin;
      m.a = static_cast<float>(side.a);
      m.b = static_cast<float>(side.b);
      m.inside = floatUp(margin - lowest(side, 1.0));
      m.touch = floatDown(-margin - highest(side, 1.0));
      m.sample = floatUp(margin - side.a * kSampleX - side.b * kSampleY);
    } else {  // decides nothing: no cell inside, every cell touched
      m.a = m.b = 0.0F;
      m.inside = m.sample = 1.0F;
      m.touch = -1.0F;
    }
  }
}

BlockSpan TriangleBlocks::span(std::uint32_t block_y) const noexcept {
  const ProjectedTriangle& t = triangle_;
  BlockSpan span;
  span.first_touched = t.cell_x0 / kBlockSide;
  span.end_touched = t.cell_x1 / kBlockSide + 1;
  for (std::uint32_t s = 0; s < t.side_count; ++s) {
    narrowTouched(t.sides[s], block_y, 0.0, span.first_touched, span.end_touched);
  }
  std::uint32_t first = span.first_touched, end = span.end_touched;
  for (std::uint32_t s = 0; s < t.side_count && first < end; ++s) {
    if (!t.sides[s].usable()) end = first;
    narrowFilled(t.moving ? swayedInwards(t.sides[s]) : t.sides[s], block_y, first, end);
  }
  // Each side is linear along the row, less a convex sway: if both ends are inside, so is
  // everything between.
  while (first < end && !filled(t, first, block_y)) ++first;
  while (first < end && !filled(t, end - 1, block_y)) --end;
  span.first_filled = first;
  span.end_filled = std::max(first, end);
  return span;
}

float TriangleBlocks::farthest(std::uint32_t block_x, std::uint32_t block_y) const noexcept {
  const double a = triangle_.depth_a, b = triangle_.depth_b;
  const double u0 = kBlockCells * block_x, v0 = kBlockCells * block_y;
  const double corner = triangle_.depth_c + a * u0 + b * v0;
  const double far = corner + kBlockCells * (std::min(a, 0.0) + std::min(b, 0.0));
  const double terms = std::abs(triangle_.depth_c) + std::abs(a) * (u0 + kBlockCells) +
                       std::abs(b) * (v0 + kBlockCells);
  return std::max(floatDown(far - 0x1p-48 * terms), depth_floor_);
}

float TriangleBlocks::nearest(std::uint32_t block_x, std::uint32_t block_y) const noexcept {
  const double a = triangle_.depth_a, b = triangle_.depth_b;
  const double corner =
      triangle_.depth_c + a * (kBlockCells * block_x) + b * (kBlockCells * block_y);
  const double near = corner + kBlockCells * (std::max(a, 0.0) + std::max(b, 0.0));
  return std::max(static_cast<float>(std::clamp(near, -1e37, 1e37)), depth_floor_);
}

bool TriangleBlocks::part(std::uint32_t block_x, std::uint32_t block_y,
                          BlockTriangle& out) const noexcept {
  out.sides = 0;
  out.net_sides = 0;
  for (std::uint32_t s = 0; s < triangle_.side_count; ++s) {
    const SideLine& side = triangle_.sides[s];
    const double sway = triangle_.moving ? swayIn(side, block_x, block_y) : 0.0;
    if (blockBeside(side, block_x, block_y, 0.0)) return false;
    if (blockInside(side, block_x, block_y, sway)) continue;
    const std::uint32_t k = out.sides++;
    const Masks& m = masks_[s];
    out.a[k] = m.a;
    out.b[k] = m.b;
    out.c[k] = side.usable() ? static_cast<float>(atBlock(side, block_x, block_y)) : 0.0F;
    out.inside[k] = m.inside;
    out.touch[k] = m.touch;
    out.sample[k] = m.sample;
    if (m.net) out.net_sides |= 1U << k;
    if (triangle_.moving) addSway(sway, out, k);
  }
  const double a = triangle_.depth_a, b = triangle_.depth_b;
  const double c = triangle_.depth_c + a * (kBlockCells * block_x) + b * (kBlockCells * block_y) +
                   std::min(a, 0.0) + std::min(b, 0.0);
  const double terms = std::abs(c) + 8.0 * (std::abs(a) + std::abs(b));
  const double slack = 0x1p-20 * terms + 1e-37;  // 16 float roundings; the kernel needs 9
  out.depth_floor = depth_floor_;
  const bool in_range = terms < 1e37;
  out.depth_a = in_range ? static_cast<float>(a) : 0.0F;
  out.depth_b = in_range ? static_cast<float>(b) : 0.0F;
  out.depth_c = in_range ? static_cast<float>(c - slack) : depth_floor_;
  return true;
}

BlockSpan TriangleBlocks::rimSpan(std::uint32_t block_y) const noexcept {
  const ProjectedTriangle& t = triangle_;
  BlockSpan span;
  span.first_touched = t.reach_x0 / kBlockSide;
  span.end_touched = t.reach_x1 / kBlockSide + 1;
  for (std::uint32_t s = 0; s < t.side_count; ++s) {
    const double sway = std::max(swayIn(t.sides[s], t.reach_x0 / kBlockSide, block_y),
                                 swayIn(t.sides[s], t.reach_x1 / kBlockSide, block_y));
    narrowTouched(t.sides[s], block_y, sway, span.first_touched, span.end_touched);
  }
  return span;
}

bool TriangleBlocks::rimPart(std::uint32_t block_x, std::uint32_t block_y,
                             BlockTriangle& out) const noexcept {
  out.sides = 0;
  out.net_sides = 0;
  for (std::uint32_t s = 0; s < triangle_.side_count; ++s) {
    const SideLine& side = triangle_.sides[s];
    const double sway = swayIn(side, block_x, block_y);
    if (blockBeside(side, block_x, block_y, sway)) return false;
    if (blockInside(side, block_x, block_y, sway)) continue;
    const std::uint32_t k = out.sides++;
    const Masks& m = masks_[s];
    const bool decided = side.usable() && sway <= kMostSway;
    const float cells = decided ? static_cast<float>(sway) : 0.0F;
    out.a[k] = decided ? m.a : 0.0F;
    out.b[k] = decided ? m.b : 0.0F;
    out.c[k] = decided ? static_cast<float>(atBlock(side, block_x, block_y)) : 0.0F;
    out.inside[k] = decided ? m.inside + cells : 1.0F;
    out.touch[k] = decided ? m.touch - cells : -1.0F;
    if (m.net) out.net_sides |= 1U << k;
  }
  return out.net_sides != 0;
}

}  // namespace culld
