// Highway code for box_kernels.h: lanes are boxes, so they never meet.
#include "culling/raster/box_kernels.h"

#include "culling/raster/rounding.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "culling/raster/box_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace culld {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<float, kBoxLanes>;
using Vec = hn::Vec<Lanes>;

// As in box_reference.cpp.
constexpr float kRelativeError = 0x1p-20F, kAbsoluteError = 1e-36F, kPadCells = 0x1p-10F;
constexpr float kSubnormal = 0x1p-126F;
constexpr float kLargest = 3.0e38F;

struct AxisVec {
  Vec low, high, reach;
};

struct RowVecs {
  Vec x[2], y[2], z[2], error;
  HWY_INLINE Vec corner(std::uint32_t c) const {
    return hn::Add(hn::Add(x[c & 1], y[c >> 1 & 1]), z[c >> 2]);
  }
};

HWY_INLINE RowVecs evaluate(Lanes d, const float* row, const AxisVec* axis) {
  const Vec r0 = hn::Set(d, row[0]), r1 = hn::Set(d, row[1]), r2 = hn::Set(d, row[2]);
  const Vec r3 = hn::Set(d, row[3]);
  const Vec near_terms =
      hn::Add(hn::Mul(hn::Abs(r0), axis[0].reach), hn::Mul(hn::Abs(r1), axis[1].reach));
  const Vec far_terms = hn::Add(hn::Mul(hn::Abs(r2), axis[2].reach), hn::Abs(r3));
  const Vec terms = hn::Add(near_terms, far_terms);
  const Vec reach = hn::Add(hn::Add(axis[0].reach, axis[1].reach), axis[2].reach);
  const Vec absolute = hn::Add(hn::Mul(reach, hn::Set(d, kSubnormal)), hn::Set(d, kAbsoluteError));
  return {{hn::Mul(r0, axis[0].low), hn::Mul(r0, axis[0].high)},
          {hn::Mul(r1, axis[1].low), hn::Mul(r1, axis[1].high)},
          {hn::Add(hn::Mul(r2, axis[2].low), r3), hn::Add(hn::Mul(r2, axis[2].high), r3)},
          hn::Add(hn::Mul(terms, hn::Set(d, kRelativeError)), absolute)};
}

struct RangeVec {
  Vec low, high;
};

HWY_INLINE RangeVec quotient(Lanes d, const RowVecs& top, const RowVecs& w, Vec w_low) {
  Vec low = hn::Set(d, std::numeric_limits<float>::infinity());
  Vec high = hn::Neg(low);
  for (std::uint32_t c = 0; c < 8; ++c) {
    const Vec value = hn::Div(top.corner(c), w.corner(c));
    low = hn::Min(low, value);
    high = hn::Max(high, value);
  }
  const Vec largest = hn::Max(hn::Abs(low), hn::Abs(high));
  const Vec scaled = hn::Div(hn::Add(top.error, hn::Mul(largest, w.error)), w_low);
  const Vec rounding = hn::Add(hn::Mul(largest, hn::Set(d, kRelativeError)), hn::Set(d, kPadCells));
  const Vec error = hn::Add(hn::Mul(scaled, hn::Set(d, 1.01F)), rounding);
  return {hn::Sub(low, error), hn::Add(high, error)};
}

// False for NaN and infinity as well.
HWY_INLINE hn::Mask<Lanes> inRange(Lanes d, const RangeVec& r) {
  return hn::And(hn::Ge(r.low, hn::Set(d, -kLargest)), hn::Le(r.high, hn::Set(d, kLargest)));
}

HWY_INLINE AxisVec loadAxis(Lanes d, double origin, const float* low, const float* high) {
  const Vec o = hn::Set(d, static_cast<float>(origin));
  const Vec lo = hn::LoadU(d, low), hi = hn::LoadU(d, high);
  return {hn::Add(o, lo), hn::Add(o, hi), hn::Add(hn::Abs(o), hn::Add(hn::Abs(lo), hn::Abs(hi)))};
}

void projectBoxesSimd(const BoxView& view, const std::array<double, 3>& origin, BoxOffsets offsets,
                      BoxRects& out) {
  const Lanes d;
  out.off_grid = 0;
  const Vec zero = hn::Zero(d), infinity = hn::Set(d, std::numeric_limits<float>::infinity());
  const Vec width = hn::Set(d, view.width), height = hn::Set(d, view.height);
  const Vec beside_limit = hn::Set(d, view.beside), behind = hn::Set(d, -view.behind);
  for (std::size_t first = 0; first < kBoxLanes; first += hn::Lanes(d)) {
    const AxisVec axis[3] = {loadAxis(d, origin[0], offsets[0] + first, offsets[3] + first),
                             loadAxis(d, origin[1], offsets[1] + first, offsets[4] + first),
                             loadAxis(d, origin[2], offsets[2] + first, offsets[5] + first)};
    const RowVecs u = evaluate(d, view.u.data(), axis), v = evaluate(d, view.v.data(), axis);
    const RowVecs w = evaluate(d, view.w.data(), axis), n = evaluate(d, view.n.data(), axis);
    Vec w_min = w.corner(0), w_max = w.corner(0), n_max = n.corner(0);
    for (std::uint32_t c = 1; c < 8; ++c) {
      w_min = hn::Min(w_min, w.corner(c));
      w_max = hn::Max(w_max, w.corner(c));
      n_max = hn::Max(n_max, n.corner(c));
    }
    const Vec w_low = hn::Sub(w_min, w.error);
    const RangeVec x = quotient(d, u, w, w_low), y = quotient(d, v, w, w_low);
    const Vec nearest = view.perspective ? hn::Mul(hn::Div(hn::Set(d, 1.0F), w_low),
                                                   hn::Set(d, 1.0F + kRelativeError))
                                         : hn::Add(n_max, n.error);
    // NaN or infinite if any input is.
    const Vec errors = hn::Add(hn::Add(u.error, v.error), hn::Add(w.error, n.error));
    const Vec largest = hn::Set(d, kLargest);
    const auto finite = hn::And(hn::Le(errors, largest), hn::Le(nearest, largest));
    const auto bounded =
        hn::And(hn::And(inRange(d, x), inRange(d, y)), hn::And(finite, hn::Gt(w_low, zero)));
    hn::StoreU(hn::IfThenElse(bounded, x.low, zero), d, out.x0.data() + first);
    hn::StoreU(hn::IfThenElse(bounded, x.high, width), d, out.x1.data() + first);
    hn::StoreU(hn::IfThenElse(bounded, y.low, zero), d, out.y0.data() + first);
    hn::StoreU(hn::IfThenElse(bounded, y.high, height), d, out.y1.data() + first);
    const auto sticks_x = hn::Or(hn::Lt(x.low, zero), hn::Gt(x.high, width));
    const auto sticks_y = hn::Or(hn::Lt(y.low, zero), hn::Gt(y.high, height));
    const auto near = hn::Gt(nearest, beside_limit);
    const auto kept = hn::And(near, hn::Or(sticks_x, sticks_y));
    hn::StoreU(hn::IfThenElse(hn::AndNot(kept, bounded), nearest, infinity), d,
               out.nearest.data() + first);
    const auto beside_x = hn::Or(hn::Lt(x.high, zero), hn::Gt(x.low, width));
    const auto beside_y = hn::Or(hn::Lt(y.high, zero), hn::Gt(y.low, height));
    const auto beside = hn::AndNot(near, hn::And(bounded, hn::Or(beside_x, beside_y)));
    const auto off = hn::Or(beside, hn::Lt(hn::Add(w_max, w.error), behind));
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, off, bits);
    out.off_grid |= static_cast<std::uint32_t>(bits[0]) << first;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace culld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace culld {

HWY_EXPORT(projectBoxesSimd);

void projectBoxes(const BoxView& view, const std::array<double, 3>& origin, BoxOffsets offsets,
                  BoxRects& out) {
  HWY_DYNAMIC_DISPATCH(projectBoxesSimd)(view, origin, offsets, out);
}

BoxView boxView(const CellView& view) noexcept {
  const auto row = [](const glm::dvec4& r) {
    return std::array<float, 4>{static_cast<float>(r.x), static_cast<float>(r.y),
                                static_cast<float>(r.z), static_cast<float>(r.w)};
  };
  BoxView box;
  box.u = row(view.u);
  box.v = row(view.v);
  box.w = row(view.w);
  box.n = row(view.n);
  box.perspective = view.perspective;
  box.width = static_cast<float>(view.grid.width);
  box.height = static_cast<float>(view.grid.height);
  box.beside = floatDown(view.beside);
  box.behind = floatUp(view.behind_m);
  return box;
}

}  // namespace culld
#endif  // HWY_ONCE
