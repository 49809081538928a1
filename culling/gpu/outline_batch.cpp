#include "culling/gpu/outline_batch.h"

#include <cmath>

#include "culling/raster/outline_rounding.h"

namespace culld::gpu {
namespace {

OutlineLine sideLine(const SideLine& side, double extent) {
  const double margin = sideMargin(side, side.c, extent);
  return {static_cast<float>(side.a), static_cast<float>(side.b), static_cast<float>(side.c),
          roundedUp(margin - leastChange(side))};
}

/// The sum of all that occurs when the plane is evaluated anywhere on the grid.
double termsOf(const DepthPlane& plane, const CellGrid& grid) {
  return std::abs(plane.c) + std::abs(plane.a) * (grid.width + 1.0) +
         std::abs(plane.b) * (grid.height + 1.0);
}

/// `extent`: width and height together.
OutlineLine planeLine(const DepthPlane& plane, double terms, double extent) {
  // A GPU may take every denormal for 0: coefficients, products and sums.
  const double slack = planeSlack(terms) + 0x1p-125 * (extent + 2.0);
  return {static_cast<float>(plane.a), static_cast<float>(plane.b),
          static_cast<float>(plane.c + leastChange(plane) - slack), 0.0F};
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
  const double extent = static_cast<double>(grid.width) + grid.height;
  for (std::uint32_t s = 0; s < outline.side_count; ++s) {
    lines.push_back(sideLine(outline.sides[s], extent));
  }
  for (std::uint32_t p = 0; p < outline.plane_count; ++p) {
    const double terms = termsOf(outline.planes[p], grid);
    if (!(terms < kMostPlaneTerms)) {
      // A plane too few would promise too much: then the floor alone.
      lines.resize(head.first_line + head.sides);
      head.planes = 0;
      break;
    }
    lines.push_back(planeLine(outline.planes[p], terms, extent));
  }
  heads.push_back(head);
}

}  // namespace culld::gpu
