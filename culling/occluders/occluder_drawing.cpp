#include "culling/occluders/occluder_drawing.h"

#include <glm/common.hpp>

#include "culling/raster/object_rows.h"

namespace culld {
namespace {

constexpr std::uint32_t kPiecesPerLook = 16;  ///< pieces between two looks at the clock

// Nanoseconds of counted work, measured (docs/planner.md).
constexpr std::uint64_t kPieceNs = 1200, kSquareNs = 80;
constexpr std::uint64_t kVertexNs = 20, kTriangleNs = 390, kDrawingWorkNs = 14;

constexpr std::uint32_t kLeastOccluderSide = 3;  ///< cells
constexpr std::uint64_t kTrianglesPerCell = 1;
constexpr std::uint64_t kVerticesPerCell = 4;

}  // namespace

bool largeEnough(const CellRect& rect) noexcept {
  return rect.x1 - rect.x0 + 1 >= kLeastOccluderSide && rect.y1 - rect.y0 + 1 >= kLeastOccluderSide;
}

bool worthDrawing(const CellRect& rect, std::uint64_t vertices,
                  std::uint64_t blocking_triangles) noexcept {
  return largeEnough(rect) && vertices <= kVerticesPerCell * rect.cells() &&
         blocking_triangles <= kTrianglesPerCell * rect.cells();
}

bool worthDrawing(const CellRect& rect, const OccluderMesh& mesh) noexcept {
  return worthDrawing(rect, mesh.vertices, mesh.blocking_triangles);
}

SheetObject sheetObjectOf(const SceneSnapshot& scene, const Instance& instance, float nearest,
                          SheetParts parts, std::vector<SheetSurface>& surfaces) {
  const Mesh& mesh = scene.mesh(instance.mesh);
  surfaces.clear();
  for (const Surface& s : mesh.surfaces) {
    if (parts == SheetParts::kBlocking && !s.blocks) continue;
    surfaces.push_back({s.first_triangle, s.triangle_count, s.double_sided});
  }
  const glm::dvec3 largest = glm::max(glm::abs(mesh.bounds.min), glm::abs(mesh.bounds.max));
  return {mesh.positions,           mesh.triangles, mesh.partners, surfaces,
          instance.world_from_mesh, largest,        nearest};
}

DrawnOccluder drawSheet(const SheetObject& object, const CellView& view,
                        const glm::dvec3& camera_origin_world, const Deadline& deadline,
                        SheetRasterizer& sheets, DepthCells& cells) {
  const DrawnSheet sheet = sheets.draw(object, view, camera_origin_world, deadline, cells);
  return {sheet.triangles,
          kVertexNs * object.positions.size() + kTriangleNs * sheet.triangles +
              kDrawingWorkNs * sheet.work,
          sheet.out_of_time};
}

DrawnOccluder OccluderDrawing::draw(const Instance& instance, float nearest,
                                    std::uint64_t most_work_ns, DepthCells& cells) const {
  DrawnOccluder drawn;
  if (!drawPieces(instance, nearest, most_work_ns, cells, drawn)) {
    drawSheet(instance, nearest, cells, drawn);
  }
  return drawn;
}

/// False: not all of it is convex pieces that can be drawn as such. Those drawn by then stay: each
/// is proven by itself.
bool OccluderDrawing::drawPieces(const Instance& instance, float nearest,
                                 std::uint64_t most_work_ns, DepthCells& cells,
                                 DrawnOccluder& drawn) const {
  const OccluderMesh& mesh = occluders_.mesh(instance.mesh);
  const int wanted = static_cast<int>(view_.front_sign * handedness(instance.world_from_mesh));
  if (mesh.piece_count == 0 || wanted == 0) return false;
  const ObjectRows rows =
      objectRows(view_, instance.world_from_mesh, origin_world_, glm::dvec3(mesh.largest));
  ConvexOutline& outline = scratch_.outline;
  for (std::uint32_t i = 0; i < mesh.piece_count; ++i) {
    if (i % kPiecesPerLook == kPiecesPerLook - 1) {
      drawn.cut_short = drawn.work_ns >= most_work_ns || deadline_.passed();
    }
    if (drawn.cut_short) return true;
    const OutlineVerdict verdict = outlineOf(occluders_.piece(mesh.first_piece + i), rows,
                                             view_.grid, view_.perspective, wanted, outline);
    drawn.work_ns += kPieceNs;
    if (verdict == OutlineVerdict::kNeedSheet) return false;
    if (verdict == OutlineVerdict::kNothing) continue;
    drawn.triangles += outline.triangles;
    drawn.work_ns += kSquareNs * drawOutline(outline, nearest, cells);
  }
  return true;
}

void OccluderDrawing::drawSheet(const Instance& instance, float nearest, DepthCells& cells,
                                DrawnOccluder& drawn) const {
  const SheetObject object =
      sheetObjectOf(scene_, instance, nearest, SheetParts::kBlocking, scratch_.surfaces);
  const DrawnOccluder sheet =
      culld::drawSheet(object, view_, origin_world_, deadline_, scratch_.sheets, cells);
  drawn.triangles += sheet.triangles;
  drawn.work_ns += sheet.work_ns;
  drawn.cut_short = sheet.cut_short;
}

}  // namespace culld
