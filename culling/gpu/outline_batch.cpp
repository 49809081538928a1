#include "culling/gpu/outline_batch.h"

#include <algorithm>
#include <cmath>

namespace culld::gpu {
namespace {

/// A float >= x, for x within a float's range.
float roundedUp(double x) { return static_cast<float>(x + 0x1p-22 * std::abs(x)); }

/// Least change from the lower corner of a cell.
template <typename Line>
double low(const Line& line) {
  return std::min(line.a, 0.0) + std::min(line.b, 0.0);
}

OutlineLine sideLine(const SideLine& side, double extent) {
  const double margin = side.error + 0x1p-20 * (std::abs(side.c) + extent);
  return {static_cast<float>(side.a), static_cast<float>(side.b), static_cast<float>(side.c),
          roundedUp(margin - low(side))};
}

/// The sum of all that occurs when the plane is evaluated anywhere on the grid.
double termsOf(const DepthPlane& plane, const CellGrid& grid) {
  return std::abs(plane.c) + std::abs(plane.a) * (grid.width + 1.0) +
         std::abs(plane.b) * (grid.height + 1.0);
}

OutlineLine planeLine(const DepthPlane& plane, double terms) {
  const double slack = 0x1p-20 * terms + 1e-37;
  return {static_cast<float>(plane.a), static_cast<float>(plane.b),
          static_cast<float>(plane.c + low(plane) - slack), 0.0F};
}

}  // namespace

void OutlineBatch::add(const ConvexOutline& outline, const CellGrid& grid) {
  const CellRect& cells = outline.cells;
  OutlineHead head{cells.x0,
                   cells.y0,
                   cells.x1 + 1,
                   cells.y1 + 1,
                   static_cast<std::uint32_t>(lines.size()),
                   outline.side_count,
                   outline.plane_count,
                   outline.depth_floor};
  const double extent = double{static_cast<double>(grid.width)} + grid.height;
  for (std::uint32_t s = 0; s < outline.side_count; ++s) {
    lines.push_back(sideLine(outline.sides[s], extent));
  }
  for (std::uint32_t p = 0; p < outline.plane_count; ++p) {
    const double terms = termsOf(outline.planes[p], grid);
    if (!(terms < 1e37)) {  // a plane too few would promise too much: then the floor alone
      lines.resize(head.first_line + head.sides);
      head.planes = 0;
      break;
    }
    lines.push_back(planeLine(outline.planes[p], terms));
  }
  heads.push_back(head);
}

}  // namespace culld::gpu
