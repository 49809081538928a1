// A convex piece as one polygon of the image: a cell inside all its sides is covered, however many
// faces meet in it. docs/error-model.md §3.1 proves why, §4.6 the arithmetic.
#pragma once
#include <array>
#include <cstdint>

#include "culling/core/convex_piece.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/depth_cells.h"
#include "culling/raster/object_rows.h"
#include "culling/raster/outline_kernels.h"
#include "culling/raster/triangle_setup.h"

namespace culld {

struct ConvexOutline {
  std::array<SideLine, kMostOutlineSides> sides;
  std::uint32_t side_count = 0;
  /// What is covered is nowhere less near than the least of these planes, nor than the floor.
  std::array<DepthPlane, kMostOutlinePlanes> planes;
  std::uint32_t plane_count = 0;
  float depth_floor = 0.0F;
  CellRect cells{};             ///< everything inside all sides lies in here
  std::uint32_t triangles = 0;  ///< faces that turn to the eye
};

enum class OutlineVerdict {
  kDraw,
  kNothing,   ///< nothing of it surely faces the eye, or it is beside the image
  kNeedSheet  ///< a clip plane may cut it, or its outline is too complicated: draw its triangles
};

/// `wanted`: sign of the projected area of a triangle that turns its front to the eye, +1 or -1.
OutlineVerdict outlineOf(const ConvexPiece& piece, const ObjectRows& rows, const CellGrid& grid,
                         bool perspective, int wanted, ConvexOutline& out) noexcept;

/// Raises `cells` wherever the outline covers them. `nearest`: no point of the piece is nearer.
/// Returns the tiles and blocks looked at.
std::uint32_t drawOutline(const ConvexOutline& outline, float nearest, DepthCells& cells);

}  // namespace culld
