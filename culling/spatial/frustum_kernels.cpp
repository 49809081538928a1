#include "culling/spatial/frustum_kernels.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "culling/spatial/frustum_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace culld {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, 8>;
using Vec = hn::Vec<Tag>;

template <class Mask>
std::uint32_t bitsOf(Tag d, Mask mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(d, mask, bytes);
  return bytes[0];
}

HWY_INLINE Vec aboveHypot(Tag d, Vec a, Vec b) {
  return hn::Add(hn::Max(a, b), hn::Mul(hn::Min(a, b), hn::Set(d, 0.41421359F)));
}

HWY_INLINE Vec turnMargin(Tag d, const float* offsets, const NodePlanes& planes) {
  Vec far[3];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const Vec node = hn::Set(d, planes.eye_to_node[axis]);
    const Vec low = hn::Abs(hn::Add(node, hn::LoadU(d, offsets + axis * 8)));
    const Vec high = hn::Abs(hn::Add(node, hn::LoadU(d, offsets + (axis + 3) * 8)));
    far[axis] = hn::Max(low, high);
  }
  const Vec distance = aboveHypot(d, aboveHypot(d, far[0], far[1]), far[2]);
  return hn::Add(hn::Mul(distance, hn::Set(d, planes.turn)), hn::Set(d, planes.turn_slack));
}

struct Value {
  Vec sum, margin;
};

HWY_INLINE Value valueAt(Tag d, const NodePlane& plane, Vec x, Vec y, Vec z) {
  const Vec base = hn::Set(d, plane.base);
  const Vec tx = hn::Mul(hn::Set(d, plane.normal[0]), x);
  const Vec ty = hn::Mul(hn::Set(d, plane.normal[1]), y);
  const Vec tz = hn::Mul(hn::Set(d, plane.normal[2]), z);
  const Vec size = hn::Add(hn::Add(hn::Abs(base), hn::Abs(tx)), hn::Add(hn::Abs(ty), hn::Abs(tz)));
  return {hn::Add(hn::Add(base, tx), hn::Add(ty, tz)),
          hn::Add(hn::Mul(size, hn::Set(d, kFrustumMargin)), hn::Set(d, plane.slack))};
}

LaneBits testLanesSimd(const float* offsets, const NodePlanes& planes) {
  const Tag d;
  const Vec zero = hn::Zero(d);
  LaneBits bits;
  for (std::uint32_t p = 0; p < kMaxPlanes; ++p) bits.inside[p] = 0;
  for (std::size_t lane = 0; lane < 8; lane += hn::Lanes(d)) {
    const float* at = offsets + lane;
    const Vec turn = planes.turn > 0.0F ? turnMargin(d, at, planes) : zero;
    auto outside = hn::Lt(zero, zero);
    for (std::uint32_t p = 0; p < planes.count; ++p) {
      const NodePlane& plane = planes.plane[p];
      const float* in_rows[3];
      const float* out_rows[3];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool rises = plane.normal[axis] >= 0.0F;
        in_rows[axis] = at + (rises ? axis + 3 : axis) * 8;
        out_rows[axis] = at + (rises ? axis : axis + 3) * 8;
      }
      const Value in = valueAt(d, plane, hn::LoadU(d, in_rows[0]), hn::LoadU(d, in_rows[1]),
                               hn::LoadU(d, in_rows[2]));
      const Value out = valueAt(d, plane, hn::LoadU(d, out_rows[0]), hn::LoadU(d, out_rows[1]),
                                hn::LoadU(d, out_rows[2]));
      outside = hn::Or(outside, hn::Lt(hn::Add(in.sum, hn::Add(in.margin, turn)), zero));
      bits.inside[p] |= bitsOf(d, hn::Gt(hn::Sub(out.sum, out.margin), zero)) << lane;
    }
    bits.outside |= bitsOf(d, outside) << lane;
  }
  return bits;
}

}  // namespace HWY_NAMESPACE
}  // namespace culld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace culld {

HWY_EXPORT(testLanesSimd);

LaneBits testLanes(const float* offsets, const NodePlanes& planes) {
  return HWY_DYNAMIC_DISPATCH(testLanesSimd)(offsets, planes);
}

}  // namespace culld
#endif
