// Highway code for occludee_kernels.h: lanes are triangles or cells of a row, and never meet.
#include "culling/raster/occludee_kernels.h"

#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "culling/raster/occludee_kernels.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace culld {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Lanes = hn::CappedTag<double, kTriangleLanes>;
using Vec = hn::Vec<Lanes>;
using Mask = hn::Mask<Lanes>;
using Floats = hn::Rebind<float, Lanes>;
using Ints = hn::Rebind<std::int32_t, Lanes>;

// As in occludee_reference.cpp.
constexpr double kUnit = 0x1p-53, kTiny = 1e-280, kHuge = 1e280, kFarBeside = 1e15, kPad = 1e-9;
constexpr double kToFloat = 0x1p-22, kSubnormal = 1e-37, kLargest = 3e38;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct CornerVecs {
  Vec u, v, w;
};

struct BoundVecs {
  Vec x0, x1, y0, y1, nearest;
  Mask bounded, behind;
};

HWY_INLINE Vec rowAt(Lanes d, const ObjectRow& row, const Vec* p) {
  const Vec xy = hn::Add(hn::Mul(hn::Set(d, row.x), p[0]), hn::Mul(hn::Set(d, row.y), p[1]));
  return hn::Add(hn::Add(xy, hn::Mul(hn::Set(d, row.z), p[2])), hn::Set(d, row.constant));
}

// Error of a place x on the image, from the errors e of u or v and ew of w.
HWY_INLINE Vec placeError(Lanes d, Vec x, double e, Vec ew, Vec r) {
  const Vec size = hn::Abs(x);
  const Vec moved = hn::Mul(hn::Add(hn::Set(d, e), hn::Mul(size, ew)), r);
  return hn::Add(hn::Mul(moved, hn::Set(d, 2.1)),
                 hn::Add(hn::Mul(size, hn::Set(d, 8.0 * kUnit)), hn::Set(d, kPad)));
}

HWY_INLINE void addCorner(Lanes d, const CellVertexError& e, const CornerVecs& p, Vec n,
                          BoundVecs& b) {
  const Vec ew = hn::Set(d, e.w), one = hn::Set(d, 1.0);
  const Vec least_w = hn::Sub(p.w, ew);
  const Mask in_front =
      hn::And(hn::Gt(least_w, hn::Mul(hn::Set(d, 0.5), p.w)), hn::Gt(least_w, hn::Set(d, kTiny)));
  b.behind = hn::And(b.behind, hn::Lt(hn::Add(p.w, ew), hn::Zero(d)));
  const Vec r = hn::Div(one, p.w);
  const Vec x = hn::Mul(p.u, r), y = hn::Mul(p.v, r);
  const Vec ex = placeError(d, x, e.u, ew, r), ey = placeError(d, y, e.v, ew, r);
  const Vec beside = hn::Set(d, kFarBeside);
  const Mask x_near = hn::Lt(hn::Add(hn::Abs(x), ex), beside);
  const Mask y_near = hn::Lt(hn::Add(hn::Abs(y), ey), beside);
  const Mask in_range = hn::And(hn::And(x_near, y_near), hn::Lt(n, hn::Set(d, kHuge)));
  b.bounded = hn::And(b.bounded, hn::And(in_front, in_range));
  b.x0 = hn::Min(b.x0, hn::Sub(x, ex));
  b.x1 = hn::Max(b.x1, hn::Add(x, ex));
  b.y0 = hn::Min(b.y0, hn::Sub(y, ey));
  b.y1 = hn::Max(b.y1, hn::Add(y, ey));
  const Vec w_loss = hn::Add(one, hn::Mul(hn::Mul(ew, r), hn::Set(d, 2.1)));
  b.nearest = hn::Max(b.nearest, hn::Mul(hn::Mul(hn::Max(n, hn::Zero(d)), r), w_loss));
}

HWY_INLINE Vec largest(Vec x, Vec y, Vec z) {
  return hn::Max(hn::Max(hn::Abs(x), hn::Abs(y)), hn::Abs(z));
}

HWY_INLINE Mask turnsAway(Lanes d, const CornerVecs* p, const CellVertexError& e, double front) {
  const Vec a = hn::Sub(hn::Mul(p[1].v, p[2].w), hn::Mul(p[1].w, p[2].v));
  const Vec b = hn::Sub(hn::Mul(p[1].w, p[2].u), hn::Mul(p[1].u, p[2].w));
  const Vec c = hn::Sub(hn::Mul(p[1].u, p[2].v), hn::Mul(p[1].v, p[2].u));
  const Vec det = hn::Add(hn::Add(hn::Mul(p[0].u, a), hn::Mul(p[0].v, b)), hn::Mul(p[0].w, c));
  const Vec eu = hn::Set(d, e.u), ev = hn::Set(d, e.v), ew = hn::Set(d, e.w);
  const Vec mu = hn::Add(largest(p[0].u, p[1].u, p[2].u), eu);
  const Vec mv = hn::Add(largest(p[0].v, p[1].v, p[2].v), ev);
  const Vec mw = hn::Add(largest(p[0].w, p[1].w, p[2].w), ew);
  const Vec spread =
      hn::Add(hn::Mul(hn::Mul(eu, mv), mw), hn::Mul(mu, hn::Add(hn::Mul(ev, mw), hn::Mul(mv, ew))));
  const Vec sum = hn::Add(hn::Add(mu, mv), hn::Add(mw, hn::Set(d, 1.0)));
  const Vec error = hn::Add(hn::Mul(spread, hn::Set(d, 8.0)), hn::Mul(sum, hn::Set(d, kTiny)));
  const Mask in_range = hn::Lt(hn::Mul(hn::Mul(mu, mv), mw), hn::Set(d, kHuge));
  return hn::And(hn::Lt(hn::Mul(det, hn::Set(d, front)), hn::Neg(error)), in_range);
}

HWY_INLINE Mask allBelow(Lanes d, const ObjectRow& row, double error, const Vec (*p)[3]) {
  const Vec limit = hn::Set(d, -error);
  const Mask first = hn::Lt(rowAt(d, row, p[0]), limit),
             second = hn::Lt(rowAt(d, row, p[1]), limit);
  return hn::And(hn::And(first, second), hn::Lt(rowAt(d, row, p[2]), limit));
}

HWY_INLINE void storeCells(Lanes d, Vec x, double side, std::uint32_t* out) {
  const Vec clamped = hn::Min(hn::Max(x, hn::Zero(d)), hn::Set(d, side - 1.0));
  const Ints ints;
  const hn::RebindToUnsigned<Ints> cells;
  hn::StoreU(hn::BitCast(cells, hn::DemoteTo(ints, clamped)), cells, out);
}

HWY_INLINE Vec otherwise(Lanes d, Mask bounded, Vec x, double value) {
  return hn::IfThenElse(bounded, x, hn::Set(d, value));
}

void projectTrianglesSimd(const OccludeeView& view, const TriangleLanes& triangles, double front,
                          TriangleRects& out) {
  const Lanes d;
  const Floats floats;
  const ObjectRows& rows = view.rows;
  const Vec zero = hn::Zero(d);
  out.unseen = 0;
  for (std::size_t first = 0; first < kTriangleLanes; first += hn::Lanes(d)) {
    const Vec large = hn::Set(d, 1e300);
    const Mask all = hn::Eq(zero, zero);
    BoundVecs b{large, hn::Neg(large), large, hn::Neg(large), zero, all, all};
    Vec p[3][3];
    CornerVecs corner[3];
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float* from = triangles.coordinate[3 * c + axis].data() + first;
        p[c][axis] = hn::PromoteTo(d, hn::LoadU(floats, from));
      }
      corner[c] = {rowAt(d, rows.u, p[c]), rowAt(d, rows.v, p[c]), rowAt(d, rows.w, p[c])};
      const Vec n = view.perspective ? hn::Set(d, 1.0)
                                     : hn::Add(rowAt(d, rows.n, p[c]), hn::Set(d, rows.error.n));
      addCorner(d, rows.error, corner[c], n, b);
    }
    const Mask beside_x = hn::Or(hn::Lt(b.x1, zero), hn::Gt(b.x0, hn::Set(d, view.width)));
    const Mask beside_y = hn::Or(hn::Lt(b.y1, zero), hn::Gt(b.y0, hn::Set(d, view.height)));
    const Mask beside = hn::And(b.bounded, hn::Or(beside_x, beside_y));
    Mask unseen = hn::Or(hn::Or(beside, b.behind), turnsAway(d, corner, rows.error, front));
    if (view.may_be_cut) {
      unseen = hn::Or(unseen, hn::Or(allBelow(d, rows.near_cut, rows.error.near_cut, p),
                                     allBelow(d, rows.far_cut, rows.error.far_cut, p)));
    }
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(d, unseen, bits);
    out.unseen |= static_cast<std::uint32_t>(bits[0]) << first;
    storeCells(d, otherwise(d, b.bounded, b.x0, 0.0), view.width, out.x0.data() + first);
    storeCells(d, otherwise(d, b.bounded, b.x1, view.width), view.width, out.x1.data() + first);
    storeCells(d, otherwise(d, b.bounded, b.y0, 0.0), view.height, out.y0.data() + first);
    storeCells(d, otherwise(d, b.bounded, b.y1, view.height), view.height, out.y1.data() + first);
    const Vec raised =
        hn::Add(hn::Mul(b.nearest, hn::Set(d, 1.0 + kToFloat)), hn::Set(d, kSubnormal));
    const Vec nearest =
        otherwise(d, hn::And(b.bounded, hn::Lt(raised, hn::Set(d, kLargest))), raised, kInfinity);
    hn::StoreU(hn::DemoteTo(floats, nearest), floats, out.nearest.data() + first);
  }
}

using Row = hn::CappedTag<float, 8>;
using RowVec = hn::Vec<Row>;

std::uint64_t cellsNotHidingSimd(const BlockTriangle& t, const BlockNearest& nearest, float least,
                                 const float* nearness) {
  const Row d;
  const std::uint32_t lanes = static_cast<std::uint32_t>(hn::Lanes(d));
  std::uint64_t open = 0;
  for (std::uint32_t first = 0; first < 8; first += lanes) {
    const RowVec column = hn::Iota(d, static_cast<float>(first));
    for (std::uint32_t j = 0; j < 8; ++j) {
      const float jf = static_cast<float>(j);
      const RowVec plane_row = hn::Set(d, nearest.c + nearest.b * jf);
      const RowVec plane = hn::Add(hn::Mul(hn::Set(d, nearest.a), column), plane_row);
      const RowVec limit = hn::Max(hn::Min(plane, hn::Set(d, nearest.ceiling)), hn::Zero(d));
      const RowVec cell = hn::Max(hn::LoadU(d, nearness + (8 * j + first)), hn::Set(d, least));
      auto not_hiding = hn::Not(hn::Gt(cell, limit));
      for (std::uint32_t s = 0; s < t.sides; ++s) {
        const RowVec row = hn::Set(d, t.c[s] + t.b[s] * jf);
        const RowVec value = hn::Add(hn::Mul(hn::Set(d, t.a[s]), column), row);
        not_hiding = hn::And(not_hiding, hn::Ge(value, hn::Set(d, t.touch[s])));
      }
      std::uint8_t bits[8] = {};
      hn::StoreMaskBits(d, not_hiding, bits);
      open |= static_cast<std::uint64_t>(bits[0]) << (8 * j + first);
    }
  }
  return open;
}

}  // namespace HWY_NAMESPACE
}  // namespace culld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace culld {

HWY_EXPORT(projectTrianglesSimd);
HWY_EXPORT(cellsNotHidingSimd);

void projectTriangles(const OccludeeView& view, const TriangleLanes& triangles, double front,
                      TriangleRects& out) {
  HWY_DYNAMIC_DISPATCH(projectTrianglesSimd)(view, triangles, front, out);
}

std::uint64_t cellsNotHiding(const BlockTriangle& triangle, const BlockNearest& nearest,
                             float least, const float* nearness) {
  return HWY_DYNAMIC_DISPATCH(cellsNotHidingSimd)(triangle, nearest, least, nearness);
}

}  // namespace culld
#endif  // HWY_ONCE
