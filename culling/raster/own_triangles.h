// The last rung of the occludee ladder: an object whose bounding rectangle sticks out of what hides
// it is asked triangle by triangle. docs/error-model.md §5.2 proves what "hidden" needs.
#pragma once
#include <cstdint>

#include "culling/core/clock.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/depth_cells.h"
#include "culling/raster/sheet.h"

namespace culld {

struct OwnTriangleVerdict {
  /// Every part of the object that could be seen is hidden. False: some is not, or cannot be
  /// decided, or the work or the time ran out.
  bool hidden = false;
  std::uint64_t work_ns = 0;  ///< counted, and priced with constants measured (docs/planner.md)
  bool out_of_time = false;
};

/// `object.surfaces` are all of the object's, also those that do not block: they are seen.
/// REQUIRES: the object has no points and lines; `view` from askedView(), and if that moves, no
/// infinite object.nearest.
/// COST: some 25 ns per triangle until the first that is not hidden, 1.5 us for each whose
/// rectangle sticks out; ends after about `most_work_ns`, at once if the triangles alone cost more.
OwnTriangleVerdict ownTrianglesHidden(const SheetObject& object, const CellView& view,
                                      const glm::dvec3& camera_origin_world,
                                      const Deadline& deadline, std::uint64_t most_work_ns,
                                      DepthCells& cells);

}  // namespace culld
