// The scalar truth of box_kernels.h, in the same order of operations as the kernel.
#include <algorithm>
#include <cmath>
#include <limits>

#include "culling/raster/box_kernels.h"

namespace culld {
namespace {

constexpr float kRelative = 0x1p-20F;    // 16 float roundings, see docs/error-model.md §5
constexpr float kAbsolute = 1e-36F;      // keeps underflow inside the margin
constexpr float kSubnormal = 0x1p-126F;  // what a coefficient below it may have lost, and more
constexpr float kPad = 0x1p-10F;         // cells
constexpr float kLargest = 3.0e38F;      // beyond it a bound is not to be trusted
constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Axis {
  float low, high, reach;  // relative to the eye; |.| bound of both and of the origin
};

struct RowBounds {
  std::array<float, 8> corner;
  float error;
};

RowBounds evaluate(const std::array<float, 4>& row, const std::array<Axis, 3>& axis) {
  RowBounds out{};
  const float x[2] = {row[0] * axis[0].low, row[0] * axis[0].high};
  const float y[2] = {row[1] * axis[1].low, row[1] * axis[1].high};
  const float z[2] = {row[2] * axis[2].low + row[3], row[2] * axis[2].high + row[3]};
  for (std::uint32_t c = 0; c < 8; ++c) out.corner[c] = (x[c & 1] + y[c >> 1 & 1]) + z[c >> 2];
  const float terms = (std::abs(row[0]) * axis[0].reach + std::abs(row[1]) * axis[1].reach) +
                      (std::abs(row[2]) * axis[2].reach + std::abs(row[3]));
  const float reach = (axis[0].reach + axis[1].reach) + axis[2].reach;
  out.error = terms * kRelative + (reach * kSubnormal + kAbsolute);
  return out;
}

struct Range {
  float low, high;
};

Range quotient(const RowBounds& top, const RowBounds& w, float w_low) {
  float low = kInfinity, high = -kInfinity;
  for (std::uint32_t c = 0; c < 8; ++c) {
    const float value = top.corner[c] / w.corner[c];
    low = std::min(low, value);
    high = std::max(high, value);
  }
  const float largest = std::max(std::abs(low), std::abs(high));
  const float error =
      ((top.error + largest * w.error) / w_low) * 1.01F + (largest * kRelative + kPad);
  return {low - error, high + error};
}

}  // namespace

void projectBoxesReference(const BoxView& view, const std::array<double, 3>& origin,
                           BoxOffsets offsets, BoxRects& out) {
  out.off_grid = 0;
  for (std::size_t lane = 0; lane < kBoxLanes; ++lane) {
    std::array<Axis, 3> axis{};
    for (std::size_t i = 0; i < 3; ++i) {
      const float o = static_cast<float>(origin[i]);
      const float low = offsets[i][lane], high = offsets[i + 3][lane];
      axis[i] = {o + low, o + high, std::abs(o) + (std::abs(low) + std::abs(high))};
    }
    const RowBounds u = evaluate(view.u, axis), v = evaluate(view.v, axis),
                    w = evaluate(view.w, axis), n = evaluate(view.n, axis);
    float w_min = w.corner[0], w_max = w.corner[0], n_max = n.corner[0];
    for (std::uint32_t c = 1; c < 8; ++c) {
      w_min = std::min(w_min, w.corner[c]);
      w_max = std::max(w_max, w.corner[c]);
      n_max = std::max(n_max, n.corner[c]);
    }
    const float w_low = w_min - w.error;
    const Range x = quotient(u, w, w_low), y = quotient(v, w, w_low);
    const float nearest = view.perspective ? (1.0F / w_low) * (1.0F + kRelative) : n_max + n.error;
    const float errors =
        (u.error + v.error) + (w.error + n.error);  // NaN or infinite if any input is
    const bool bounded = errors <= kLargest && w_low > 0.0F && nearest <= kLargest &&
                         x.low >= -kLargest && x.high <= kLargest && y.low >= -kLargest &&
                         y.high <= kLargest;
    out.x0[lane] = bounded ? x.low : 0.0F;
    out.x1[lane] = bounded ? x.high : view.width;
    out.y0[lane] = bounded ? y.low : 0.0F;
    out.y1[lane] = bounded ? y.high : view.height;
    const bool sticks_out =
        x.low < 0.0F || x.high > view.width || y.low < 0.0F || y.high > view.height;
    const bool near = nearest > view.beside;
    out.nearest[lane] = bounded && !(near && sticks_out) ? nearest : kInfinity;
    const bool beside =
        bounded && !near &&
        (x.high < 0.0F || x.low > view.width || y.high < 0.0F || y.low > view.height);
    const bool behind = w_max + w.error < -view.behind;
    if (beside || behind) out.off_grid |= 1U << lane;
  }
}

}  // namespace culld
