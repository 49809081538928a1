// Draws one object's blocking triangles as a sheet: a cell is covered if no net edge touches it and
// one triangle holds its sample point, however many triangles meet in it. The net-edge lemma and
// its use are in docs/error-model.md §3.
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "culling/core/clock.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/coverage_kernels.h"
#include "culling/raster/depth_cells.h"
#include "culling/raster/triangle_blocks.h"

namespace culld {

/// A run of triangles of one kind.
struct SheetSurface {
  std::uint32_t first_triangle, triangle_count;
  bool double_sided;
};

/// An object as an occluder: mesh-space triangles, CCW from the front, and where they stand.
struct SheetObject {
  std::span<const glm::vec3> positions;
  std::span<const std::array<std::uint32_t, 3>> triangles;
  std::span<const std::uint32_t> partners;  ///< opposite half-edge of half-edge 3 * t + e, or ~0
  std::span<const SheetSurface> surfaces;   ///< those that block
  std::array<double, 12> world_from_mesh;   ///< three rows of four
  glm::dvec3 largest;                       ///< of |x|, |y|, |z| over positions
  float nearest;                            ///< no point of it is nearer (see BoxRects)
};

struct DrawnSheet {
  std::uint32_t triangles = 0;
  std::uint64_t work = 0;  ///< blocks visited, triangles and eighths of vertices looked at
  bool out_of_time = false;
};

/// Scratch memory, reused from object to object.
class SheetRasterizer {
 public:
  /// With `whole`, what cells are raised to does not depend on what was drawn before, at the price
  /// of more work: else a sheet is given up in a block once one of its triangles cannot raise that.
  void drawWhole(bool whole) noexcept { whole_ = whole; }

  /// Raises `cells` wherever the object surely hides what is behind it. Cut short by the deadline,
  /// or for an object that would cover the image many times over, it raises less, never more.
  DrawnSheet draw(const SheetObject& object, const CellView& view,
                  const glm::dvec3& camera_origin_world, const Deadline& deadline,
                  DepthCells& cells);
  std::size_t bytes() const noexcept;

 private:
  /// A triangle of a moving sheet with its net edges.
  struct Rim {
    ProjectedTriangle triangle;
    std::uint32_t net_edges;
  };

  bool mayGoOn(std::uint32_t work);
  void transform(const SheetObject& object, const CellView& view, const glm::dvec3& origin);
  void orient(const SheetObject& object, double front_sign);
  std::uint32_t drawTriangles(const SheetObject& object, DepthCells& cells);
  void drawTriangle(const SheetObject& object, std::uint32_t triangle,
                    const OrientedTriangle& oriented, DepthCells& cells);
  void drawBlock(const TriangleBlocks& blocks, std::uint32_t block_x, std::uint32_t block_y,
                 float nearest, DepthCells& cells);
  void fillBlock(std::uint32_t block, float farthest, DepthCells& cells);
  void giveUp(std::uint32_t block);
  std::uint32_t newSlot(std::uint32_t block);
  void forgetTouched() noexcept;
  SheetBlock& sheetBlock(std::uint32_t block);
  void drawRims(const DepthCells& cells);
  void finish(DepthCells& cells);

  const Deadline* deadline_ = nullptr;  ///< of the draw under way
  std::uint64_t work_left_ = 0;         ///< blocks, before the object is given up
  std::uint32_t work_to_look_ = 0;      ///< blocks, before the next look at the clock
  bool whole_ = false;
  bool stopped_ = false;
  bool out_of_time_ = false;
  GridSize grid_{};
  CellVertexError error_;
  std::vector<CellVertex> vertices_;
  std::vector<std::int8_t> orientation_;    ///< per triangle: 0 = not part of the sheet
  std::vector<OrientedTriangle> oriented_;  ///< of those in the sheet, in order
  std::vector<std::uint32_t> touched_;      ///< blocks of this object, in the order of their slots
  std::vector<std::uint32_t> slot_of_block_;
  std::vector<SheetBlock> blocks_;  ///< by slot
  std::vector<Rim> rims_;           ///< empty if the eye is still
  BlockTriangle part_;
  SheetBlock scrap_;  ///< takes what goes to blocks that were given up
};

}  // namespace culld
