// Highway code for coverage_kernels.h. Rows of eight cells; results do not depend on the lane
// count, since lanes never meet except in min, max and bit masks.
#include "culling/raster/coverage_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "culling/raster/coverage_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace culld {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Row = hn::CappedTag<float, 8>;
using RowVec = hn::Vec<Row>;
using RowMask = hn::Mask<Row>;

// Bits of a mask, lowest lane first.
inline std::uint64_t bitsOf(Row d, RowMask mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return bytes[0];
}

// Lanes whose bit in `bits` is set.
inline RowMask maskOf(Row d, std::uint64_t bits) {
  const std::uint8_t bytes[8] = {static_cast<std::uint8_t>(bits)};
  return hn::LoadMaskBits(d, bytes);
}

void addTriangleSimd(const BlockTriangle& t, SheetBlock& sheet, float* nearness) {
  const Row d;
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(d));
  for (std::uint32_t first = 0; first < 8; first += lanes) {
    const RowVec column = hn::Iota(d, static_cast<float>(first));
    const std::uint64_t lane_bits = (std::uint64_t{1} << lanes) - 1;
    for (std::uint32_t j = 0; j < 8; ++j) {
      std::uint64_t inside = lane_bits, touched = lane_bits, sampled = lane_bits, rim = 0;
      const float jf = static_cast<float>(j);
      for (std::uint32_t s = 0; s < t.sides; ++s) {
        const RowVec row = hn::Set(d, t.c[s] + t.b[s] * jf);
        const RowVec value = hn::Add(hn::Mul(hn::Set(d, t.a[s]), column), row);
        const std::uint64_t side_inside = bitsOf(d, hn::Ge(value, hn::Set(d, t.inside[s])));
        inside &= side_inside;
        touched &= bitsOf(d, hn::Ge(value, hn::Set(d, t.touch[s])));
        sampled &= bitsOf(d, hn::Ge(value, hn::Set(d, t.sample[s])));
        if (t.net_sides >> s & 1U) rim |= ~side_inside;
      }
      if (touched == 0) continue;
      const std::uint32_t cell = 8 * j + first;
      const RowVec plane_row = hn::Set(d, t.depth_c + t.depth_b * jf);
      const RowVec plane = hn::Add(hn::Mul(hn::Set(d, t.depth_a), column), plane_row);
      const RowVec depth = hn::Max(plane, hn::Set(d, t.depth_floor));
      const RowVec old_far = hn::LoadU(d, sheet.farthest.data() + cell);
      hn::StoreU(hn::IfThenElse(maskOf(d, touched), hn::Min(old_far, depth), old_far), d,
                 sheet.farthest.data() + cell);
      sheet.rim |= (rim & touched) << cell;
      sheet.sampled |= (sampled & touched) << cell;
      const std::uint64_t full = inside & touched;
      if (full == 0) continue;
      const RowVec old_near = hn::LoadU(d, nearness + cell);
      hn::StoreU(hn::IfThenElse(maskOf(d, full), hn::Max(old_near, depth), old_near), d,
                 nearness + cell);
    }
  }
}

std::uint64_t rimCellsSimd(const BlockTriangle& t) {
  const Row d;
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(d));
  const std::uint64_t lane_bits = (std::uint64_t{1} << lanes) - 1;
  std::uint64_t cells = 0;
  for (std::uint32_t first = 0; first < 8; first += lanes) {
    const RowVec column = hn::Iota(d, static_cast<float>(first));
    for (std::uint32_t j = 0; j < 8; ++j) {
      std::uint64_t touched = lane_bits, rim = 0;
      for (std::uint32_t s = 0; s < t.sides; ++s) {
        const RowVec row = hn::Set(d, t.c[s] + t.b[s] * static_cast<float>(j));
        const RowVec value = hn::Add(hn::Mul(hn::Set(d, t.a[s]), column), row);
        touched &= bitsOf(d, hn::Ge(value, hn::Set(d, t.touch[s])));
        if (t.net_sides >> s & 1U) rim |= ~bitsOf(d, hn::Ge(value, hn::Set(d, t.inside[s])));
      }
      cells |= (rim & touched) << (8 * j + first);
    }
  }
  return cells;
}

float raiseCellsSimd(std::uint64_t covered, const float* farthest, float* nearness) {
  const Row d;
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(d));
  RowVec least = hn::Set(d, 3.0e38F);
  for (std::uint32_t cell = 0; cell < 64; cell += lanes) {
    const RowVec old = hn::LoadU(d, nearness + cell);
    const RowMask take = maskOf(d, covered >> cell);
    const RowVec raised = hn::IfThenElse(take, hn::Max(old, hn::LoadU(d, farthest + cell)), old);
    hn::StoreU(raised, d, nearness + cell);
    least = hn::Min(least, raised);
  }
  return hn::GetLane(hn::MinOfLanes(d, least));
}

std::uint64_t cellsNearerThanSimd(const float* nearness, float limit) {
  const Row d;
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(d));
  const RowVec bound = hn::Set(d, limit);
  std::uint64_t mask = 0;
  for (std::uint32_t cell = 0; cell < 64; cell += lanes) {
    mask |= bitsOf(d, hn::Gt(hn::LoadU(d, nearness + cell), bound)) << cell;
  }
  return mask;
}

}  // namespace HWY_NAMESPACE
}  // namespace culld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace culld {

HWY_EXPORT(addTriangleSimd);
HWY_EXPORT(rimCellsSimd);
HWY_EXPORT(raiseCellsSimd);
HWY_EXPORT(cellsNearerThanSimd);

void addTriangle(const BlockTriangle& triangle, SheetBlock& sheet, float* nearness) {
  HWY_DYNAMIC_DISPATCH(addTriangleSimd)(triangle, sheet, nearness);
}

std::uint64_t rimCells(const BlockTriangle& triangle) {
  return HWY_DYNAMIC_DISPATCH(rimCellsSimd)(triangle);
}

float raiseCells(std::uint64_t covered, const float* farthest, float* nearness) {
  return HWY_DYNAMIC_DISPATCH(raiseCellsSimd)(covered, farthest, nearness);
}

std::uint64_t cellsNearerThan(const float* nearness, float limit) {
  return HWY_DYNAMIC_DISPATCH(cellsNearerThanSimd)(nearness, limit);
}

}  // namespace culld
#endif  // HWY_ONCE
