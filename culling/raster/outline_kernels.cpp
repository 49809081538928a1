// Highway code for outline_kernels.h: vectors are runs of parts, so lanes meet only in masks and
// minima, and results do not depend on their number.
#include "culling/raster/outline_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "culling/raster/outline_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace culld {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Parts = hn::CappedTag<float, 16>;
using PartsVec = hn::Vec<Parts>;

alignas(64) constexpr float kColumn[16] = {0, 1, 2, 3, 4, 5, 6, 7, 0, 1, 2, 3, 4, 5, 6, 7};
alignas(64) constexpr float kRow[64] = {
    0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 2, 2, 2, 3, 3, 3, 3, 3, 3, 3, 3,
    4, 4, 4, 4, 4, 4, 4, 4, 5, 5, 5, 5, 5, 5, 5, 5, 6, 6, 6, 6, 6, 6, 6, 6, 7, 7, 7, 7, 7, 7, 7, 7};

HWY_INLINE std::uint64_t bitsOf(Parts d, hn::Mask<Parts> mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return bytes[0] | static_cast<std::uint64_t>(bytes[1]) << 8;
}

HWY_INLINE hn::Mask<Parts> maskOf(Parts d, std::uint64_t bits) {
  const std::uint8_t bytes[8] = {static_cast<std::uint8_t>(bits),
                                 static_cast<std::uint8_t>(bits >> 8)};
  return hn::LoadMaskBits(d, bytes);
}

HWY_INLINE PartsVec valueAt(Parts d, float a, float b, float c, std::uint32_t part) {
  const PartsVec row = hn::Add(hn::Set(d, c), hn::Mul(hn::Set(d, b), hn::Load(d, kRow + part)));
  return hn::Add(hn::Mul(hn::Set(d, a), hn::Load(d, kColumn + part % 8)), row);
}

void outlineMasksSimd(const OutlineSquare& square, const float* nearness, OutlineMasks& masks) {
  const Parts d;
  const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
  masks.full = masks.some = ~std::uint64_t{0};
  for (std::uint32_t s = 0; s < square.sides; ++s) {
    std::uint64_t full = 0, some = 0;
    for (std::uint32_t part = 0; part < 64; part += lanes) {
      const PartsVec value = valueAt(d, square.a[s], square.b[s], square.c[s], part);
      full |= bitsOf(d, hn::Ge(value, hn::Set(d, square.full[s]))) << part;
      some |= bitsOf(d, hn::Ge(value, hn::Set(d, square.some[s]))) << part;
    }
    masks.full_of_side[s] = full;
    masks.full &= full;
    masks.some &= some;
  }
  masks.raisable = 0;
  for (std::uint32_t part = 0; part < 64; part += lanes) {
    PartsVec top = hn::Set(d, square.depth_ceiling);
    for (std::uint32_t p = 0; p < square.planes; ++p) {
      const PartsVec low =
          valueAt(d, square.plane_a[p], square.plane_b[p], square.plane_c[p], part);
      top = hn::Min(top, hn::Add(low, hn::Set(d, square.plane_rise[p])));
    }
    top = hn::Max(top, hn::Set(d, square.depth_floor));
    masks.raisable |= bitsOf(d, hn::Gt(top, hn::LoadU(d, nearness + part))) << part;
  }
}

std::uint64_t outlineInsideSimd(const OutlineSquare& square) {
  const Parts d;
  const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
  std::uint64_t inside = ~std::uint64_t{0};
  for (std::uint32_t s = 0; s < square.sides; ++s) {
    std::uint64_t full = 0;
    for (std::uint32_t part = 0; part < 64; part += lanes) {
      const PartsVec value = valueAt(d, square.a[s], square.b[s], square.c[s], part);
      full |= bitsOf(d, hn::Ge(value, hn::Set(d, square.full[s]))) << part;
    }
    inside &= full;
  }
  return inside;
}

float raiseOutlineSimd(const OutlineSquare& square, std::uint64_t covered, float* nearness) {
  const Parts d;
  const auto lanes = static_cast<std::uint32_t>(hn::Lanes(d));
  PartsVec least = hn::Set(d, 3.0e38F);
  for (std::uint32_t part = 0; part < 64; part += lanes) {
    PartsVec depth = hn::Set(d, 3.0e38F);
    for (std::uint32_t p = 0; p < square.planes; ++p) {
      depth =
          hn::Min(depth, valueAt(d, square.plane_a[p], square.plane_b[p], square.plane_c[p], part));
    }
    depth = hn::Max(depth, hn::Set(d, square.depth_floor));
    const PartsVec old = hn::LoadU(d, nearness + part);
    const PartsVec raised = hn::IfThenElse(maskOf(d, covered >> part), hn::Max(old, depth), old);
    hn::StoreU(raised, d, nearness + part);
    least = hn::Min(least, raised);
  }
  return hn::GetLane(hn::MinOfLanes(d, least));
}

}  // namespace HWY_NAMESPACE
}  // namespace culld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace culld {

HWY_EXPORT(outlineMasksSimd);
HWY_EXPORT(outlineInsideSimd);
HWY_EXPORT(raiseOutlineSimd);

void outlineMasks(const OutlineSquare& square, const float* nearness, OutlineMasks& masks) {
  HWY_DYNAMIC_DISPATCH(outlineMasksSimd)(square, nearness, masks);
}

std::uint64_t outlineInside(const OutlineSquare& square) {
  return HWY_DYNAMIC_DISPATCH(outlineInsideSimd)(square);
}

float raiseOutline(const OutlineSquare& square, std::uint64_t covered, float* nearness) {
  return HWY_DYNAMIC_DISPATCH(raiseOutlineSimd)(square, covered, nearness);
}

}  // namespace culld
#endif  // HWY_ONCE
