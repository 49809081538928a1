#include "culling/raster/horizon.h"

#include <algorithm>
#include <bit>

namespace culld {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

bool holds(const RowSpan& span, const ColumnRect& rect) {
  return span.low <= rect.y0 && rect.y1 <= span.high;
}

RowSpan joined(const RowSpan& a, const RowSpan& b) {
  if (a.empty()) return b;
  if (a.low <= b.high && b.low <= a.high) {
    return {std::min(a.low, b.low), std::max(a.high, b.high)};
  }
  return b.high - b.low > a.high - a.low ? b : a;
}

}  // namespace

void Horizon::reset(std::uint32_t columns, bool tree) {
  leaves_ = std::bit_ceil(std::max(columns, 1U));
  tree_ = tree;
  least_ = kInfinity;
  looks_ = 0;
  spans_.assign(std::size_t{2} * leaves_, RowSpan{});
  for (std::uint32_t c = columns; c < leaves_; ++c) spans_[leaves_ + c] = {-kInfinity, kInfinity};
  if (columns < leaves_) refit(columns, leaves_ - 1);
}

void Horizon::refit(std::uint32_t first, std::uint32_t last) {
  for (first += leaves_, last += leaves_; first > 1;) {
    first /= 2;
    last /= 2;
    for (std::uint32_t at = first; at <= last; ++at) {
      const RowSpan &a = spans_[2 * std::size_t{at}], &b = spans_[2 * std::size_t{at} + 1];
      spans_[at] = {std::max(a.low, b.low), std::min(a.high, b.high)};
    }
  }
}

void Horizon::raise(std::uint32_t first, std::span<const RowSpan> spans, float nearness) {
  if (!(nearness > 0.0F) || spans.empty()) return;
  least_ = std::min(least_, nearness);
  for (std::size_t i = 0; i < spans.size(); ++i) {
    RowSpan& column = spans_[leaves_ + first + i];
    if (!spans[i].empty()) column = joined(column, spans[i]);
  }
  if (tree_) refit(first, first + static_cast<std::uint32_t>(spans.size()) - 1);
}

bool Horizon::certainlyHidden(const ColumnRect& rect, float nearest) {
  if (!(nearest < least_) || least_ == kInfinity) return false;
  if (tree_) return spans(1, 0, leaves_, rect);
  for (std::uint32_t c = rect.x0; c <= rect.x1; ++c) {
    ++looks_;
    if (!holds(spans_[leaves_ + c], rect)) return false;
  }
  return true;
}

/// Do all columns of the rectangle below node `at`, which has columns first.., hold its rows?
bool Horizon::spans(std::uint32_t at, std::uint32_t first, std::uint32_t count,
                    const ColumnRect& rect) {
  ++looks_;
  if (holds(spans_[at], rect)) return true;
  if (count == 1) return false;
  const std::uint32_t half = count / 2, middle = first + half;
  return (rect.x0 >= middle || spans(2 * at, first, half, rect)) &&
         (rect.x1 < middle || spans(2 * at + 1, middle, half, rect));
}

bool Horizon::covers(std::uint32_t first, std::span<const RowSpan> spans) const {
  for (std::size_t i = 0; i < spans.size(); ++i) {
    const RowSpan& column = spans_[leaves_ + first + i];
    const bool within = column.low <= spans[i].low && spans[i].high <= column.high;
    if (!spans[i].empty() && !within) return false;
  }
  return true;
}

float Horizon::shareBeyond(const ColumnRect& rect) const {
  const std::uint32_t columns = rect.x1 - rect.x0 + 1, step = (columns + 15) / 16;
  float within = 0.0F, all = 0.0F;
  for (std::uint32_t c = rect.x0; c <= rect.x1; c += step) {
    const RowSpan& column = spans_[leaves_ + c];
    const float rows = std::min(column.high, rect.y1) - std::max(column.low, rect.y0);
    within += std::max(rows, 0.0F);
    all += rect.y1 - rect.y0;
  }
  return 1.0F - within / all;
}

}  // namespace culld
