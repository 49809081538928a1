#include "culling/raster/sheet_skyline.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "culling/raster/object_rows.h"
#include "culling/raster/rounding.h"

namespace culld {
namespace {

constexpr double kFarthestPlace = 1e9;  ///< cells; beyond, a vertex is not used
constexpr double kCutError = 1.5;       ///< a cut's error, of a vertex's
constexpr std::uint8_t kCutEdge = 3;    ///< runs along the near plane
constexpr std::uint32_t kNoPartner = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kStepsPerLook = 1024;  ///< vertices or triangles; some 30 us
constexpr std::size_t kMarksPerColumn = 16;    ///< more rims than rows: given up

double nearnessOf(const CellVertex& p, const CellVertexError& error) {
  const double n = p.n - error.n;
  return n > 0.0 ? n / (p.w + error.w) * (1.0 - 0x1p-50) : 0.0;
}

std::uint32_t clampColumn(double x, double width) {
  return static_cast<std::uint32_t>(std::clamp(x, 0.0, width - 1.0));
}

/// The least that a plane has within the extent, rounded down; -infinity if it is not known.
double leastOf(const DepthPlane& plane, double x0, double x1, double y0, double y1) {
  const double across = std::max(std::abs(plane.a * x0), std::abs(plane.a * x1));
  const double up = std::max(std::abs(plane.b * y0), std::abs(plane.b * y1));
  const double least = plane.c + std::min(plane.a * x0, plane.a * x1) +
                       std::min(plane.b * y0, plane.b * y1) -
                       0x1p-44 * (std::abs(plane.c) + across + up);
  return plane.known && std::isfinite(least) ? least : -std::numeric_limits<double>::infinity();
}

}  // namespace

/// False once the time is used up.
bool SheetSkyline::mayGoOn() {
  if (++steps_ % kStepsPerLook == 0) out_of_time_ = out_of_time_ || deadline_->passed();
  return !out_of_time_;
}

SheetSkyline::Place SheetSkyline::placeOf(const CellVertex& p, const CellVertexError& error) {
  const double x = p.u / p.w, y = p.v / p.w, least_w = p.w - error.w;
  const auto wrong = [&](double at, double of) {
    return 1.01 * (of + std::abs(at) * error.w) / least_w + 0x1p-48 * std::abs(at) + 1e-9;
  };
  const bool usable = p.w > 4.0 * error.w && p.near_cut > 2.0 * error.near_cut &&
                      p.far_cut > 2.0 * error.far_cut && std::abs(x) < kFarthestPlace &&
                      std::abs(y) < kFarthestPlace;
  return {x, y, wrong(x, error.u), wrong(y, error.v), nearnessOf(p, error), usable};
}

void SheetSkyline::place(const SheetObject& object, const CellView& view,
                         const glm::dvec3& origin) {
  const ObjectRows rows = objectRows(view, object.world_from_mesh, origin, object.largest);
  error_ = rows.error;
  vertices_.resize(object.positions.size());
  places_.resize(object.positions.size());
  for (std::size_t i = 0; i < vertices_.size() && mayGoOn(); ++i) {
    vertices_[i] = rows.at(glm::dvec3(object.positions[i]));
    places_[i] = placeOf(vertices_[i], error_);
  }
}

/// The point of edge a-b that lies just beyond the near plane: the same for both its triangles.
std::uint32_t SheetSkyline::addCut(std::uint32_t a, std::uint32_t b) {
  const CellVertex &p = vertices_[std::min(a, b)], &q = vertices_[std::max(a, b)];
  const double beyond = 8.0 * error_.near_cut;
  const double t = std::clamp((beyond - p.near_cut) / (q.near_cut - p.near_cut), 0.0, 1.0);
  const auto at = [t](double from, double to) { return from + t * (to - from); };
  const CellVertex cut{at(p.u, q.u),
                       at(p.v, q.v),
                       at(p.w, q.w),
                       at(p.n, q.n),
                       at(p.near_cut, q.near_cut),
                       at(p.far_cut, q.far_cut)};
  CellVertexError error = error_;
  for (double* e : {&error.u, &error.v, &error.w, &error.n, &error.near_cut, &error.far_cut}) {
    *e *= kCutError;
  }
  places_.push_back(placeOf(cut, error));
  return static_cast<std::uint32_t>(places_.size() - 1);
}

/// False: nothing of the triangle is left, or it reaches what cannot be cut off.
bool SheetSkyline::cutAtNear(const std::array<std::uint32_t, 3>& corner, Turned& turned) {
  const auto add = [&](std::uint32_t at, std::uint32_t edge) {
    turned.corner[turned.corners] = at;
    turned.edge[turned.corners++] = static_cast<std::uint8_t>(edge);
    return places_[at].usable;
  };
  const auto beyond = [&](std::uint32_t v) {
    return vertices_[v].near_cut > 2.0 * error_.near_cut;
  };
  for (std::uint32_t e = 0; e < 3; ++e) {
    const std::uint32_t from = corner[e], to = corner[(e + 1) % 3];
    if (beyond(from) && !add(from, e)) return false;
    if (beyond(from) != beyond(to) && !add(addCut(from, to), beyond(from) ? kCutEdge : e)) {
      return false;
    }
  }
  return turned.corners != 0;
}

void SheetSkyline::orient(const SheetObject& object, double front_sign) {
  orientation_.assign(object.triangles.size(), 0);
  turned_.clear();
  for (const SheetSurface& surface : object.surfaces) {
    const int wanted = surface.double_sided ? 0 : (front_sign > 0.0 ? 1 : -1);
    for (std::uint32_t i = 0; i < surface.triangle_count && mayGoOn(); ++i) {
      const std::uint32_t t = surface.first_triangle + i;
      const auto& corner = object.triangles[t];
      const OrientedTriangle oriented = orientTriangle(vertices_[corner[0]], vertices_[corner[1]],
                                                       vertices_[corner[2]], error_, grid_, wanted);
      Turned turned{oriented, t, 0, {}, {}};
      if (oriented.orientation == 0 || !cutAtNear(corner, turned)) continue;
      orientation_[t] = static_cast<std::int8_t>(oriented.orientation);
      turned_.push_back(turned);
    }
  }
}

std::size_t SheetSkyline::columnsReached() const {
  double x0 = grid_.width, x1 = 0.0;
  for (const Turned& turned : turned_) {
    for (std::uint32_t i = 0; i < turned.corners; ++i) {
      const double x = places_[turned.corner[i]].x;
      x0 = std::min(x0, x);
      x1 = std::max(x1, x);
    }
  }
  return static_cast<std::size_t>(std::max(std::min(x1, grid_.width) - std::max(x0, 0.0), 0.0));
}

void SheetSkyline::markNetEdges(const SheetObject& object) {
  marks_.clear();
  most_marks_ = kMarksPerColumn * (columnsReached() + 1);
  first_column_ = std::numeric_limits<std::uint32_t>::max();
  last_column_ = 0;
  for (const Turned& turned : turned_) {
    if (marks_.size() > most_marks_ || !mayGoOn()) return;
    const int orientation = turned.oriented.orientation;
    for (std::uint32_t i = 0; i < turned.corners; ++i) {
      if (turned.edge[i] != kCutEdge) {
        const std::uint32_t partner = object.partners[3 * turned.triangle + turned.edge[i]];
        if (partner != kNoPartner && orientation_[partner / 3] == orientation) continue;
      }
      const std::uint32_t next = turned.corner[(i + 1) % turned.corners];
      markEdge(places_[turned.corner[i]], places_[next], orientation);
    }
  }
}

void SheetSkyline::markEdge(const Place& from, const Place& to, int orientation) {
  const double reach_x = std::max(from.error_x, to.error_x);
  const double slack =
      std::max(from.error_y, to.error_y) + 0x1p-44 * (std::abs(from.y) + std::abs(to.y)) + 1e-6;
  const double left = std::min(from.x, to.x) - reach_x, right = std::max(from.x, to.x) + reach_x;
  const bool above = std::min(from.y, to.y) - slack > grid_.height;
  if (above || right < 0.0 || left > grid_.width) return;
  const std::uint32_t first = clampColumn(std::ceil(left) - 1.0, grid_.width);
  const std::uint32_t last = clampColumn(std::floor(right), grid_.width);
  first_column_ = std::min(first_column_, first);
  last_column_ = std::max(last_column_, last);
  const double run = to.x - from.x, rise = to.y - from.y;
  const auto rowAt = [&](double x) {
    const double along = run == 0.0 ? 0.0 : std::clamp((x - from.x) / run, 0.0, 1.0);
    return from.y + along * rise;
  };
  const int step = run > 0.0 ? orientation : -orientation;
  for (std::uint32_t column = first; column <= last; ++column) {
    double a = rowAt(column - reach_x), b = rowAt(column + 1.0 + reach_x);
    if (run == 0.0) b = to.y;
    const double middle = column + 0.5;
    const bool passes = (from.x < middle) != (to.x < middle);
    marks_.push_back({column, floatDown(std::min(a, b) - slack), floatUp(std::max(a, b) + slack),
                      passes ? step : 0});
  }
}

/// By column, then by their lower rows.
void SheetSkyline::sortMarks() {
  const std::size_t columns = last_column_ - first_column_ + 1;
  begin_.assign(columns + 1, 0);
  for (const Mark& mark : marks_) ++begin_[mark.column - first_column_ + 1];
  for (std::size_t c = 0; c < columns; ++c) begin_[c + 1] += begin_[c];
  sorted_.resize(marks_.size());
  for (const Mark& mark : marks_) sorted_[begin_[mark.column - first_column_]++] = mark;
  for (std::size_t c = columns; c > 0; --c) begin_[c] = begin_[c - 1];
  begin_[0] = 0;
  for (std::size_t c = 0; c < columns; ++c) {
    std::sort(sorted_.begin() + begin_[c], sorted_.begin() + begin_[c + 1],
              [](const Mark& a, const Mark& b) { return a.low < b.low; });
  }
}

/// Between the rows that net edges may touch the number of triangles is the same throughout.
RowSpan SheetSkyline::longestRun(std::uint32_t column) const {
  RowSpan longest;
  const auto top = static_cast<float>(grid_.height);
  float reached = 0.0F, length = 0.0F;
  std::int32_t triangles = 0;
  const auto gapTo = [&](float mark) {
    const float row = std::min(mark, top);  // edges above the image have no marks
    if (triangles >= 1 && row - reached > length) {
      longest = {reached, row};
      length = row - reached;
    }
  };
  const std::uint32_t end = begin_[column - first_column_ + 1];
  for (std::uint32_t i = begin_[column - first_column_]; i < end; ++i) {
    const Mark& mark = sorted_[i];
    gapTo(mark.low);
    reached = std::max(reached, mark.high);
    triangles += mark.step;
  }
  gapTo(top);
  return longest;
}

void SheetSkyline::appendSlices(std::uint32_t columns, HorizonSlices& out) {
  for (std::uint32_t first = first_column_; first <= last_column_;) {
    const std::uint32_t end =
        columns == 0 ? last_column_ : std::min(last_column_, first + columns - 1);
    out.slices.push_back({first, end - first + 1, static_cast<std::uint32_t>(out.spans.size()),
                          std::numeric_limits<float>::infinity()});
    for (std::uint32_t column = first; column <= end; ++column) {
      out.spans.push_back(longestRun(column));
    }
    first = end + 1;
  }
}

SheetSkyline::Extent SheetSkyline::extentOf(const Turned& turned) const {
  Extent extent{HUGE_VAL, -HUGE_VAL, HUGE_VAL, -HUGE_VAL, HUGE_VAL};
  for (std::uint32_t i = 0; i < turned.corners; ++i) {
    const Place& p = places_[turned.corner[i]];
    extent.nearness = std::min(extent.nearness, p.nearness);
    extent.x0 = std::min(extent.x0, p.x - p.error_x);
    extent.x1 = std::max(extent.x1, p.x + p.error_x);
    extent.y0 = std::min(extent.y0, p.y - p.error_y);
    extent.y1 = std::max(extent.y1, p.y + p.error_y);
  }
  return extent;
}

/// A slice is as near as the farthest of what the triangles that may touch it have there.
void SheetSkyline::setNearness(const SheetObject& object, std::uint32_t columns,
                               std::size_t first_slice, HorizonSlices& out) {
  std::vector<RowSpan> rows;  // of whole slices
  for (std::size_t s = first_slice; s < out.slices.size(); ++s) {
    RowSpan all;
    for (const RowSpan& span : out.spansOf(out.slices[s])) {
      all = {std::min(all.low, span.low), std::max(all.high, span.high)};
    }
    rows.push_back(all);
  }
  const double width = columns == 0 ? grid_.width : columns;
  for (const Turned& turned : turned_) {
    const auto& corner = object.triangles[turned.triangle];
    const Extent extent = extentOf(turned);
    if (extent.x1 < first_column_ || extent.x0 > last_column_ + 1.0) continue;
    const auto slice = [&](double x) {
      const auto last = static_cast<double>(rows.size() - 1);
      return static_cast<std::size_t>(std::clamp((x - first_column_) / width, 0.0, last));
    };
    const std::size_t first = slice(extent.x0 - 1.0), last = slice(extent.x1 + 1.0);
    DepthPlane plane;
    if (first != last) {
      plane = depthPlane(vertices_[corner[0]], vertices_[corner[1]], vertices_[corner[2]], error_,
                         grid_, turned.oriented);
    }
    for (std::size_t s = first; s <= last; ++s) {
      if (!(extent.y0 <= rows[s].high && rows[s].low <= extent.y1)) continue;
      HorizonSlice& to = out.slices[first_slice + s];
      const double x0 = to.first_column, x1 = x0 + to.columns;
      const double there = leastOf(plane, std::max(x0, extent.x0), std::min(x1, extent.x1),
                                   std::max<double>(rows[s].low, extent.y0),
                                   std::min<double>(rows[s].high, extent.y1));
      to.nearness = std::min(to.nearness, floatDown(std::max(extent.nearness, there)));
    }
  }
}

SkylineWork SheetSkyline::append(const SheetObject& object, const CellView& view,
                                 const glm::dvec3& camera_origin_world, std::uint32_t columns,
                                 const Deadline& deadline, HorizonSlices& out) {
  const double front_sign = view.front_sign * handedness(object.world_from_mesh);
  if (front_sign == 0.0) return {};
  grid_ = {static_cast<double>(view.grid.width), static_cast<double>(view.grid.height)};
  deadline_ = &deadline;
  out_of_time_ = false;
  place(object, view, camera_origin_world);
  orient(object, front_sign);
  markNetEdges(object);
  const SkylineWork work{static_cast<std::uint32_t>(turned_.size()), marks_.size(), out_of_time_};
  if (marks_.empty() || marks_.size() > most_marks_ || out_of_time_) return work;
  sortMarks();
  const std::size_t first_slice = out.slices.size();
  appendSlices(columns, out);
  setNearness(object, columns, first_slice, out);
  for (std::size_t s = first_slice; s < out.slices.size(); ++s) {
    if (!std::isfinite(out.slices[s].nearness)) out.slices[s].nearness = 0.0F;  // no rows
  }
  return work;
}

}  // namespace culld
