// Which rows of each column of the image an object hides, from its net edges alone: no cells, no
// depth buffer, any mesh. The net-edge lemma (docs/error-model.md §3) on whole columns;
// docs/error-model/horizon.md proves it and the arithmetic.
#pragma once
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "culling/core/clock.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/horizon.h"
#include "culling/raster/sheet.h"
#include "culling/raster/triangle_setup.h"

namespace culld {

/// Every ray through these columns, within their spans, meets a blocking surface at least so near.
struct HorizonSlice {
  std::uint32_t first_column, columns;
  std::uint32_t first_span;  ///< in HorizonSlices::spans
  float nearness;
};

/// What occluders bring to a horizon: runs of columns, each with a nearness of its own, so that a
/// long wall joins the horizon bit by bit as a sweep passes it.
struct HorizonSlices {
  std::vector<HorizonSlice> slices;
  std::vector<RowSpan> spans;

  void clear() noexcept {
    slices.clear();
    spans.clear();
  }
  std::span<const RowSpan> spansOf(const HorizonSlice& slice) const noexcept {
    return {spans.data() + slice.first_span, slice.columns};
  }
};

struct SkylineWork {
  std::uint32_t triangles = 0;  ///< that turn a blocking side to the eye
  std::uint64_t marks = 0;      ///< columns of net edges looked at
  bool out_of_time = false;     ///< then nothing was appended
};

/// Scratch memory, reused from object to object.
class SheetSkyline {
 public:
  /// Appends the longest run of rows of each column that the object surely hides, in slices of at
  /// most `columns` (0: one slice). Nothing for an object with too many net edges, or cut short.
  /// REQUIRES: a view that does not move.
  SkylineWork append(const SheetObject& object, const CellView& view,
                     const glm::dvec3& camera_origin_world, std::uint32_t columns,
                     const Deadline& deadline, HorizonSlices& out);

 private:
  /// A vertex on the image, within +- its errors, and a nearness that it does not fall below.
  struct Place {
    double x, y, error_x, error_y, nearness;
    bool usable;  ///< surely between the clip planes and before the eye
  };
  /// What is left of a triangle that turns a blocking side to the eye, beyond the near plane.
  struct Turned {
    OrientedTriangle oriented;
    std::uint32_t triangle;
    std::uint32_t corners = 0;
    std::array<std::uint32_t, 4> corner;  ///< places
    std::array<std::uint8_t, 4> edge;     ///< of the triangle, that leaves the corner; or the cut
  };
  /// Rows of one column that a net edge may touch.
  struct Mark {
    std::uint32_t column;
    float low, high;
    std::int32_t step;  ///< added to the number of triangles above, if it passes the middle
  };
  /// Columns and rows that a triangle may touch, and how near all of it is at least.
  struct Extent {
    double x0, x1, y0, y1, nearness;
  };

  static Place placeOf(const CellVertex& p, const CellVertexError& error);
  bool mayGoOn();
  void place(const SheetObject& object, const CellView& view, const glm::dvec3& origin);
  void orient(const SheetObject& object, double front_sign);
  bool cutAtNear(const std::array<std::uint32_t, 3>& corner, Turned& turned);
  std::uint32_t addCut(std::uint32_t a, std::uint32_t b);
  std::size_t columnsReached() const;
  void markNetEdges(const SheetObject& object);
  void markEdge(const Place& from, const Place& to, int orientation);
  void sortMarks();
  RowSpan longestRun(std::uint32_t column) const;
  void appendSlices(std::uint32_t columns, HorizonSlices& out);
  void setNearness(const SheetObject& object, std::uint32_t columns, std::size_t first_slice,
                   HorizonSlices& out);
  Extent extentOf(const Turned& turned) const;

  const Deadline* deadline_ = nullptr;  ///< of the call under way
  std::uint32_t steps_ = 0;
  bool out_of_time_ = false;
  GridSize grid_{};
  CellVertexError error_;
  std::vector<CellVertex> vertices_;
  std::vector<Place> places_;             ///< of the vertices, then of cuts
  std::vector<std::int8_t> orientation_;  ///< per triangle: 0 = not part of the sheet
  std::vector<Turned> turned_;
  std::size_t most_marks_ = 0;
  std::vector<Mark> marks_, sorted_;
  std::uint32_t first_column_ = 0, last_column_ = 0;  ///< with marks
  std::vector<std::uint32_t> begin_;  ///< of each of these columns in sorted_, and the end
};

}  // namespace culld
