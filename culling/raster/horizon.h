// The occlusion horizon: per column of the image the rows behind which nothing is seen, under a
// binary tree of columns (after Downs, Moller, Sequin 2001, "Occlusion horizons for driving through
// urban scenery"). Departs from it: rows have a lower edge too, as nothing says that what is below
// a building is hidden, and no depth per column but one for all: the order of a front-to-back sweep
// keeps it high. docs/error-model/horizon.md proves what it hides.
#pragma once
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace culld {

/// Rows of one column, in cells and fractions of them; closed. low > high: none.
struct RowSpan {
  float low = std::numeric_limits<float>::infinity();
  float high = -std::numeric_limits<float>::infinity();
  bool empty() const noexcept { return !(low <= high); }
};

/// Whole columns x0..x1, both included, and a closed range of rows.
struct ColumnRect {
  std::uint32_t x0, x1;
  float y0, y1;
};

class Horizon {
 public:
  /// Forgets everything. `tree`: off, columns are looked at one by one.
  void reset(std::uint32_t columns, bool tree);

  /// REQUIRES: every ray through columns first.., within their spans, meets a blocking surface of
  /// at least this nearness. Of rows that do not meet those of the column, the longer ones stay.
  void raise(std::uint32_t first, std::span<const RowSpan> spans, float nearness);

  /// GUARANTEES: something within the rectangle, nowhere nearer than `nearest`, is behind blocking
  /// surfaces on every ray. NaN is not hidden. REQUIRES: x1 is a column.
  bool certainlyHidden(const ColumnRect& rect, float nearest);
  /// Nothing of these spans would raise the horizon.
  bool covers(std::uint32_t first, std::span<const RowSpan> spans) const;

  /// About the share of the rectangle that is beyond the horizon's rows.
  float shareBeyond(const ColumnRect& rect) const;

  std::uint64_t looks() const noexcept { return looks_; }  ///< nodes and columns looked at

 private:
  bool spans(std::uint32_t at, std::uint32_t first, std::uint32_t count, const ColumnRect& rect);
  void refit(std::uint32_t first, std::uint32_t last);

  std::uint32_t leaves_ = 0;  ///< a power of two
  bool tree_ = true;
  float least_ = std::numeric_limits<float>::infinity();  ///< of all that was raised
  /// Node k has the children 2k and 2k + 1 and the rows that all its columns have; column c is
  /// node leaves_ + c. Columns beyond the image have all rows.
  std::vector<RowSpan> spans_;
  std::uint64_t looks_ = 0;
};

}  // namespace culld
