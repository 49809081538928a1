#include "culling/raster/convex_outline.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "culling/core/piece_contour.h"
#include "culling/raster/rounding.h"

namespace culld {
namespace {

/// What a piece is on its way to an outline.
struct Setup {
  std::array<CellVertex, kMostPieceVertices> vertices;
  std::uint64_t front = 0;                     ///< bit f: face f surely turns to the eye
  bool beyond_near = true, before_far = true;  ///< all vertices surely are
  GridSize grid;
};

/// False: some face that turns to the eye may be cut by a clip plane.
bool orientFaces(const ConvexPiece& piece, const CellVertexError& error, int wanted, Setup& setup,
                 ConvexOutline& out) {
  for (std::size_t f = 0; f < piece.faces.size(); ++f) {
    const auto& corner = piece.faces[f].corner;
    const CellVertex &p = setup.vertices[corner[0]], &q = setup.vertices[corner[1]],
                     &r = setup.vertices[corner[2]];
    const OrientedTriangle oriented = orientTriangle(p, q, r, error, setup.grid, wanted);
    if (oriented.orientation == 0) continue;
    // What moves may come from beside the image: then only the vertices can tell.
    const auto uncut = [&](const std::array<double, 3>& k, double k_error) {
      return error.motion.still && surelyPositive(k, k_error, setup.grid, oriented);
    };
    const bool near =
        setup.beyond_near || uncut({p.near_cut, q.near_cut, r.near_cut}, error.near_cut);
    const bool far = setup.before_far || uncut({p.far_cut, q.far_cut, r.far_cut}, error.far_cut);
    if (!near || !far) return false;
    setup.front |= std::uint64_t{1} << f;
    ++out.triangles;
    if (out.triangles > kMostOutlinePlanes) continue;
    const DepthPlane plane = depthPlane(p, q, r, error, setup.grid, oriented);
    if (plane.known) out.planes[out.plane_count++] = plane;
  }
  // A plane too few would promise too much: then the floor alone stands for all faces.
  if (out.plane_count != out.triangles) out.plane_count = 0;
  return true;
}

/// Grows by what of an edge's end can be on the image.
struct Extent {
  double u0 = std::numeric_limits<double>::infinity(), u1 = -u0, v0 = u0, v1 = -u0;
  double largest_w = 0.0, least_n = u0;
  bool bounded = true;

  void grow(const CellVertex& p, double w_error) {
    largest_w = std::max(largest_w, p.w);
    least_n = std::min(least_n, p.n);
    if (!(p.w > 4.0 * w_error)) {
      bounded = false;
      return;
    }
    const double inverse = 1.0 / p.w, u = p.u * inverse, v = p.v * inverse;
    u0 = std::min(u0, u);
    u1 = std::max(u1, u);
    v0 = std::min(v0, v);
    v1 = std::max(v1, v);
  }
};

/// Cells between two places; a cell too many costs time, one too few some coverage.
bool cellsBetween(double low, double high, std::uint32_t side, std::uint32_t& first,
                  std::uint32_t& last) {
  if (!(high > 0.0) || !(low < side)) return false;
  const double top = static_cast<double>(side) - 1.0;
  first = static_cast<std::uint32_t>(std::clamp(low, 0.0, top));
  last = static_cast<std::uint32_t>(std::clamp(high, 0.0, top));
  return true;
}

bool setCells(const Extent& extent, const CellGrid& grid, CellRect& cells) {
  if (!extent.bounded) {
    cells = {0, grid.width - 1, 0, grid.height - 1};
    return true;
  }
  return cellsBetween(extent.u0, extent.u1, grid.width, cells.x0, cells.x1) &&
         cellsBetween(extent.v0, extent.v1, grid.height, cells.y0, cells.y1);
}

/// The edges between what turns to the eye and what does not. False: too many, or one is uncertain.
bool addSides(const ConvexPiece& piece, const CellVertexError& error, int wanted,
              const Setup& setup, Extent& extent, ConvexOutline& out) {
  for (const PieceEdge& edge : piece.edges) {
    const EdgeRole role = roleOf(edge, setup.front);
    if (role == EdgeRole::kAway) continue;
    const CellVertex &from = setup.vertices[edge.from], &to = setup.vertices[edge.to];
    if (role == EdgeRole::kInner) {
      extent.largest_w = std::max({extent.largest_w, from.w, to.w});
      extent.least_n = std::min({extent.least_n, from.n, to.n});
      continue;
    }
    extent.grow(from, error.w);
    extent.grow(to, error.w);
    if (out.side_count == kMostOutlineSides) return false;
    const bool forward = role == EdgeRole::kForward;
    const CellVertex &p = forward ? from : to, &q = forward ? to : from;
    const SideLine side = sideOf(p, q, lineThrough(p, q, error), error, setup.grid, wanted);
    if (!side.usable()) return false;
    out.sides[out.side_count++] = side;
  }
  return true;
}

/// A side that holds however all moves: moved inwards by its sway, which counts where it is
/// positive.
SideLine swayedInwards(const SideLine& s, const CellRect& cells) {
  const double x0 = cells.x0 - cells.x0 % kBlockSide, y0 = cells.y0 - cells.y0 % kBlockSide;
  const double x1 = cells.x1 - cells.x1 % kBlockSide + kBlockSide;
  const double y1 = cells.y1 - cells.y1 % kBlockSide + kBlockSide;
  const double least =
      s.sway_c + std::min(s.sway_a * x0, s.sway_a * x1) + std::min(s.sway_b * y0, s.sway_b * y1);
  const double most =
      s.sway_c + std::max(s.sway_a * x0, s.sway_a * x1) + std::max(s.sway_b * y0, s.sway_b * y1);
  const bool everywhere = least >= 0.0;
  const double a = everywhere ? s.a - s.sway_a : s.a, b = everywhere ? s.b - s.sway_b : s.b;
  const double c = s.c - (everywhere ? s.sway_c : std::max(most, 0.0));
  const double length = std::abs(a) + std::abs(b);
  const double terms = std::abs(s.sway_a) * x1 + std::abs(s.sway_b) * y1 + std::abs(s.sway_c);
  const double error = s.error + 0x1p-44 * (x1 + y1 + std::abs(s.c) + terms);
  return {a / length, b / length, c / length, 1.01 * error / length};
}

/// False: some side decides nothing.
bool addSway(ConvexOutline& out) {
  for (std::uint32_t s = 0; s < out.side_count; ++s) {
    SideLine& side = out.sides[s];
    side = swayedInwards(side, out.cells);
    if (!side.usable() || !std::isfinite(side.c)) return false;
  }
  return true;
}

}  // namespace

OutlineVerdict outlineOf(const ConvexPiece& piece, const ObjectRows& rows, const CellGrid& grid,
                         bool perspective, int wanted, ConvexOutline& out) noexcept {
  out.side_count = out.plane_count = out.triangles = 0;
  if (piece.vertices.size() > kMostPieceVertices || piece.faces.size() > kMostPieceFaces) {
    return OutlineVerdict::kNeedSheet;
  }
  Setup setup;
  setup.grid = {static_cast<double>(grid.width), static_cast<double>(grid.height)};
  for (std::size_t v = 0; v < piece.vertices.size(); ++v) {
    const CellVertex vertex = rows.at(glm::dvec3(piece.vertices[v]));
    setup.beyond_near = setup.beyond_near && vertex.near_cut > 2.0 * rows.error.near_cut;
    setup.before_far = setup.before_far && vertex.far_cut > 2.0 * rows.error.far_cut;
    setup.vertices[v] = vertex;
  }
  if (!orientFaces(piece, rows.error, wanted, setup, out)) return OutlineVerdict::kNeedSheet;
  if (setup.front == 0) return OutlineVerdict::kNothing;
  Extent extent;
  if (!addSides(piece, rows.error, wanted, setup, extent, out)) return OutlineVerdict::kNeedSheet;
  const bool in_front = extent.largest_w > rows.error.w;
  if (!in_front || out.side_count == 0 || !setCells(extent, grid, out.cells))
    return OutlineVerdict::kNothing;
  if (!rows.error.motion.still && !addSway(out)) return OutlineVerdict::kNeedSheet;
  const double floor =
      perspective ? 1.0 / (extent.largest_w + rows.error.w) : extent.least_n - rows.error.n;
  out.depth_floor = floatDown(floor - 0x1p-50 * std::abs(floor));
  return OutlineVerdict::kDraw;
}

}  // namespace culld
