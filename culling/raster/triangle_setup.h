// From three projected vertices to half-planes and a depth plane over the image, with every
// rounding error on the safe side. Homogeneous edge functions (Olano, Greer 1997): no clipping, a
// triangle may reach behind the eye. docs/error-model.md §4 derives each bound used here.
#pragma once
#include <array>
#include <cstdint>

#include "culling/raster/eye_motion.h"

namespace culld {

/// A vertex through CellView's rows.
struct CellVertex {
  double u, v, w, n, near_cut, far_cut;
};

/// What is not known about the vertices of one object.
struct CellVertexError {
  /// Bounds on |computed - true| of each component, for every vertex by itself.
  double u = 0, v = 0, w = 0, n = 0, near_cut = 0, far_cut = 0;
  /// And all may move together; the cuts stay where they are on the object.
  EyeMotion motion{};
};

/// One half-plane a * u + b * v + c >= 0 of the image, scaled to |a| + |b| = 1.
/// True value - computed value is within +- error (cells) everywhere on the grid. If all moves, the
/// side still does not reach a place whose value's size is > error + max(sway, 0) there.
struct SideLine {
  double a, b, c, error;
  double sway_a = 0.0, sway_b = 0.0, sway_c = 0.0;       ///< cells; all 0 if nothing moves
  bool usable() const noexcept { return error <= 0.5; }  ///< worse, and it decides nothing
};

/// At most: three edges and the cuts at the two clip planes.
inline constexpr std::uint32_t kMaxSides = 5;

/// A triangle that surely turns one known side to the eye.
struct ProjectedTriangle {
  std::array<SideLine, kMaxSides> sides;  ///< edge 0->1, 1->2, 2->0, then the clip cuts it needs
  std::uint32_t side_count = 3;
  double depth_a = 0, depth_b = 0, depth_c = 0;  ///< nearness is never less than this plane
  double depth_floor = 0;                        ///< nor than this
  /// Cells that the triangle may touch, clamped to the grid; the whole grid if it nears the eye.
  std::uint32_t cell_x0 = 0, cell_x1 = 0, cell_y0 = 0, cell_y1 = 0;
  bool on_grid = false;
  bool moving = false;  ///< then it may also be in these cells
  std::uint32_t reach_x0 = 0, reach_x1 = 0, reach_y0 = 0, reach_y1 = 0;
  bool reaches_grid = false;
};

struct GridSize {
  double width, height;
};

/// Cross product of two vertices, the line through them over the image, unscaled; and bounds on its
/// errors.
struct EdgeLine {
  double a, b, c;
  double error_a, error_b, error_c;
};

EdgeLine lineThrough(const CellVertex& p, const CellVertex& q,
                     const CellVertexError& error) noexcept;
/// The line through p and q as a half-plane, positive on the left of p -> q, or for orientation -1
/// on its right.
SideLine sideOf(const CellVertex& p, const CellVertex& q, const EdgeLine& line,
                const CellVertexError& error, const GridSize& grid, int orientation) noexcept;

/// Which way a triangle turns on the image, and what tells it: the same lines and determinant make
/// the half-planes and the depth of those that are drawn.
struct OrientedTriangle {
  /// +1 / -1: sign of the projected area, certain in spite of rounding and motion; 0: not certain,
  /// not asked for, or the numbers are out of range. The lines are valid only where it is not 0.
  int orientation = 0;
  EdgeLine pq, qr, rp;
  double determinant, determinant_error;
};

/// `wanted`: the only orientation asked for, +1 or -1; 0: both. COST: about 40 flops, 100 for a
/// triangle that is oriented as wanted.
OrientedTriangle orientTriangle(const CellVertex& p, const CellVertex& q, const CellVertex& r,
                                const CellVertexError& error, const GridSize& grid,
                                int wanted) noexcept;

/// REQUIRES: `oriented` made from the same arguments, its orientation not 0.
ProjectedTriangle projectTriangle(const CellVertex& p, const CellVertex& q, const CellVertex& r,
                                  const CellVertexError& error, const GridSize& grid,
                                  const OrientedTriangle& oriented) noexcept;

/// Nearness a * u + b * v + c over the image, if known.
struct DepthPlane {
  double a = 0, b = 0, c = 0;
  bool known = false;
};

/// A plane that the nearness of the triangle's plane falls below nowhere on the grid.
/// REQUIRES: as projectTriangle.
DepthPlane depthPlane(const CellVertex& p, const CellVertex& q, const CellVertex& r,
                      const CellVertexError& error, const GridSize& grid,
                      const OrientedTriangle& oriented) noexcept;

/// A quantity that is linear in space and k_i at vertex i is surely positive on the triangle's
/// whole plane, as far as it is on the image. REQUIRES: as depthPlane.
bool surelyPositive(const std::array<double, 3>& k, double k_error, const GridSize& grid,
                    const OrientedTriangle& oriented) noexcept;

}  // namespace culld
