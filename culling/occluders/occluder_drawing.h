// Draws one object as an occluder: its convex pieces as outlines if all that blocks of it is such,
// else its triangles as a sheet. The one way in which methods turn objects into cells
// (docs/error-model.md §3).
#pragma once
#include <cstdint>
#include <limits>
#include <vector>

#include "culling/core/clock.h"
#include "culling/occluders/occluder_set.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/convex_outline.h"
#include "culling/raster/depth_cells.h"
#include "culling/raster/sheet.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

enum class SheetParts { kBlocking, kAll };

/// The object's triangles for drawing them (kBlocking) or for asking after them (kAll). Valid as
/// long as `surfaces`, which it fills, and the snapshot.
SheetObject sheetObjectOf(const SceneSnapshot& scene, const Instance& instance, float nearest,
                          SheetParts parts, std::vector<SheetSurface>& surfaces);

/// Smaller ones rarely fill any cell.
bool largeEnough(const CellRect& rect) noexcept;
/// Large enough, and with no more detail than cells. A choice of cost: it changes no promise.
/// `vertices`: all of the mesh's, as all of them are transformed.
bool worthDrawing(const CellRect& rect, std::uint64_t vertices,
                  std::uint64_t blocking_triangles) noexcept;
bool worthDrawing(const CellRect& rect, const OccluderMesh& mesh) noexcept;

/// Buffers kept from object to object for their memory only.
struct OccluderScratch {
  SheetRasterizer sheets;
  std::vector<SheetSurface> surfaces;
  ConvexOutline outline;
};

struct DrawnOccluder {
  std::uint32_t triangles = 0;
  std::uint64_t work_ns = 0;  ///< counted, and priced with constants measured (docs/planner.md)
  bool cut_short = false;     ///< by time or work: less is covered, never more
};

/// An object's triangles as a sheet, or those of them that `object.surfaces` names: raises `cells`
/// wherever they surely hide what is behind them, and prices the work.
DrawnOccluder drawSheet(const SheetObject& object, const CellView& view,
                        const glm::dvec3& camera_origin_world, const Deadline& deadline,
                        SheetRasterizer& sheets, DepthCells& cells);

/// The occluders of one frame. Keeps references to all that it is given.
class OccluderDrawing {
 public:
  OccluderDrawing(const SceneSnapshot& scene, const OccluderSet& occluders, const CellView& view,
                  const glm::dvec3& camera_origin_world, const Deadline& deadline,
                  OccluderScratch& scratch)
      : scene_(scene),
        occluders_(occluders),
        view_(view),
        origin_world_(camera_origin_world),
        deadline_(deadline),
        scratch_(scratch) {}

  static constexpr std::uint64_t kNoLimit = std::numeric_limits<std::uint64_t>::max();

  /// Raises `cells` wherever the object surely hides what is behind it.
  /// REQUIRES: no point of the object is nearer than `nearest`; it has a bound. Pieces stop after
  /// about `most_work_ns` of counted work, a sheet only by the deadline and its own limit.
  DrawnOccluder draw(const Instance& instance, float nearest, std::uint64_t most_work_ns,
                     DepthCells& cells) const;

 private:
  bool drawPieces(const Instance& instance, float nearest, std::uint64_t most_work_ns,
                  DepthCells& cells, DrawnOccluder& drawn) const;
  void drawSheet(const Instance& instance, float nearest, DepthCells& cells,
                 DrawnOccluder& drawn) const;

  const SceneSnapshot& scene_;
  const OccluderSet& occluders_;
  const CellView& view_;
  glm::dvec3 origin_world_;
  const Deadline& deadline_;
  OccluderScratch& scratch_;
};

}  // namespace culld
