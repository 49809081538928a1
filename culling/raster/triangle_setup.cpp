#include "culling/raster/triangle_setup.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace culld {
namespace {

constexpr double kUnit = 0x1p-53;  ///< half an ulp of 1
constexpr double kTiny = 1e-280;   ///< below this, underflow could exceed the error bounds

double gridError(const EdgeLine& line, const GridSize& g) {
  return line.error_a * g.width + line.error_b * g.height + line.error_c;
}

double gridMax(const EdgeLine& line, const GridSize& g) {
  return std::abs(line.a) * g.width + std::abs(line.b) * g.height + std::abs(line.c);
}

EdgeLine lineThrough(const CellVertex& p, const CellVertex& q, const CellVertexError& e) {
  const double mu = std::max(std::abs(p.u), std::abs(q.u)) + e.u;
  const double mv = std::max(std::abs(p.v), std::abs(q.v)) + e.v;
  const double mw = std::max(std::abs(p.w), std::abs(q.w)) + e.w;
  EdgeLine line;
  line.a = p.v * q.w - p.w * q.v;
  line.b = p.w * q.u - p.u * q.w;
  line.c = p.u * q.v - p.v * q.u;
  line.error_a = 3.0 * (mv * e.w + mw * e.v);
  line.error_b = 3.0 * (mu * e.w + mw * e.u);
  line.error_c = 3.0 * (mu * e.v + mv * e.u);
  return line;
}

struct Determinant {
  double value, error;
};

Determinant determinant(const CellVertex& p, const EdgeLine& qr, const CellVertexError& e) {
  const double value = p.u * qr.a + p.v * qr.b + p.w * qr.c;
  const double terms = std::abs(p.u * qr.a) + std::abs(p.v * qr.b) + std::abs(p.w * qr.c);
  const double from_line =
      std::abs(p.u) * qr.error_a + std::abs(p.v) * qr.error_b + std::abs(p.w) * qr.error_c;
  const double from_vertex = e.u * (std::abs(qr.a) + qr.error_a) +
                             e.v * (std::abs(qr.b) + qr.error_b) +
                             e.w * (std::abs(qr.c) + qr.error_c);
  return {value, 1.01 * (from_line + from_vertex) + 4.0 * kUnit * terms};
}

/// The unscaled line as a half-plane with the triangle on its positive side.
SideLine sideLine(double a, double b, double c, double error, const GridSize& g, int orientation) {
  const double length = std::abs(a) + std::abs(b);
  const double scale = static_cast<double>(orientation) / length;
  SideLine side{a * scale, b * scale, c * scale, 0.0};
  side.error = 1.01 * error / length + 8.0 * kUnit * (g.width + g.height + std::abs(side.c));
  const bool usable = length > kTiny && std::isfinite(side.a) && std::isfinite(side.b) &&
                      std::isfinite(side.c) && side.usable();
  if (!usable) return {0.0, 0.0, 0.0, std::numeric_limits<double>::infinity()};
  return side;
}

/// Sum of e_i * k_i: for a quantity that is k_i at vertex i, its sign over the image.
struct Combined {
  double a, b, c, error;
};

Combined combine(const std::array<EdgeLine, 3>& opposite, const std::array<double, 3>& k,
                 double k_error, const GridSize& g) {
  Combined sum{0.0, 0.0, 0.0, 0.0};
  double terms = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    sum.a += opposite[i].a * k[i];
    sum.b += opposite[i].b * k[i];
    sum.c += opposite[i].c * k[i];
    terms += gridMax(opposite[i], g) * std::abs(k[i]);
    sum.error +=
        gridError(opposite[i], g) * (std::abs(k[i]) + k_error) + gridMax(opposite[i], g) * k_error;
  }
  sum.error = 1.01 * sum.error + 8.0 * kUnit * terms;
  return sum;
}

void setDepth(ProjectedTriangle& t, const std::array<const CellVertex*, 3>& vertex,
              const std::array<EdgeLine, 3>& opposite, const Determinant& det,
              const CellVertexError& e, const GridSize& g) {
  double floor = std::numeric_limits<double>::infinity();
  for (const CellVertex* p : vertex) {
    if (!(p->w > -e.w)) continue;  // behind the eye: the visible part is nearer than the others
    const double n = p->n - e.n;
    floor = std::min(floor, n / (n >= 0.0 ? p->w + e.w : p->w - e.w));
  }
  floor -= 4.0 * kUnit * std::abs(floor);
  t.depth_floor = floor;
  t.depth_a = t.depth_b = 0.0;
  t.depth_c = floor;
  const std::array<double, 3> n{vertex[0]->n, vertex[1]->n, vertex[2]->n};
  // The vertex errors of n are constant over the triangle (docs/error-model.md §4.5): added below.
  const Combined sum = combine(opposite, n, 0.0, g);
  const double sign = det.value > 0.0 ? 1.0 : -1.0;
  const double scale = sign * (1.0 - 8.0 * kUnit) / (std::abs(det.value) + det.error);
  const double a = sum.a * scale, b = sum.b * scale, c = sum.c * scale;
  const double rounding =
      8.0 * kUnit * (std::abs(a) * g.width + std::abs(b) * g.height + std::abs(c));
  const double loss = 1.01 * (sum.error * std::abs(scale) + e.n) + rounding;
  if (!std::isfinite(a) || !std::isfinite(b) || !std::isfinite(c - loss)) return;
  t.depth_a = a;
  t.depth_b = b;
  t.depth_c = c - loss;
}

void addCut(ProjectedTriangle& t, const std::array<EdgeLine, 3>& opposite,
            const std::array<double, 3>& k, double k_error, const GridSize& g, int orientation) {
  if (std::min({k[0], k[1], k[2]}) > 2.0 * k_error) return;  // wholly on the visible side
  const Combined sum = combine(opposite, k, k_error, g);
  t.sides[t.side_count++] = sideLine(sum.a, sum.b, sum.c, sum.error, g, orientation);
}

/// Clamped cell range of [low, high]; false if it misses [0, side].
bool cellRange(double low, double high, double side, std::uint32_t& first, std::uint32_t& last) {
  if (high < 0.0 || low > side) return false;
  const double top = side - 1.0;
  first = static_cast<std::uint32_t>(low > 0.0 ? std::min(low, top) : 0.0);
  last = static_cast<std::uint32_t>(high < top ? std::max(high, 0.0) : top);
  return true;
}

void setCells(ProjectedTriangle& t, const std::array<const CellVertex*, 3>& vertex,
              const CellVertexError& e, const GridSize& g) {
  double u0 = g.width, u1 = 0.0, v0 = g.height, v1 = 0.0;
  bool bounded = true, any_in_front = false;
  bool first = true;
  for (const CellVertex* p : vertex) {
    any_in_front = any_in_front || p->w > -e.w;
    const double least_w = p->w - e.w;
    if (!(least_w > 0.5 * std::abs(p->w)) || !(least_w > kTiny)) {
      bounded = false;
      continue;
    }
    const double u = p->u / p->w, v = p->v / p->w;
    const double eu = 1.01 * (e.u + std::abs(u) * e.w) / least_w + 4.0 * kUnit * std::abs(u) + 1e-9;
    const double ev = 1.01 * (e.v + std::abs(v) * e.w) / least_w + 4.0 * kUnit * std::abs(v) + 1e-9;
    u0 = first ? u - eu : std::min(u0, u - eu);
    u1 = first ? u + eu : std::max(u1, u + eu);
    v0 = first ? v - ev : std::min(v0, v - ev);
    v1 = first ? v + ev : std::max(v1, v + ev);
    first = false;
  }
  if (!any_in_front) return;
  if (!bounded) {
    u0 = v0 = 0.0;
    u1 = g.width;
    v1 = g.height;
  }
  t.on_grid = cellRange(u0, u1, g.width, t.cell_x0, t.cell_x1) &&
              cellRange(v0, v1, g.height, t.cell_y0, t.cell_y1);
}

}  // namespace

OrientedTriangle orientTriangle(const CellVertex& p, const CellVertex& q, const CellVertex& r,
                                const CellVertexError& error, const GridSize& grid,
                                int wanted) noexcept {
  OrientedTriangle out;
  out.qr = lineThrough(q, r, error);
  const Determinant det = determinant(p, out.qr, error);
  const double size = std::abs(det.value);
  // Both bounds fail for NaN and infinity: such a triangle is not used.
  if (!(size > det.error + kTiny) || !(size < 1e280)) return out;
  const int sign = det.value > 0.0 ? 1 : -1;
  if (wanted != 0 && sign != wanted) return out;
  for (const CellVertex* a : {&p, &q, &r}) {
    if (!(std::abs(a->n) < 1e280 && std::abs(a->near_cut) < 1e280 &&
          std::abs(a->far_cut) < 1e280)) {
      return out;
    }
  }
  out.rp = lineThrough(r, p, error);
  out.pq = lineThrough(p, q, error);
  const double reach = gridMax(out.qr, grid) + gridMax(out.rp, grid) + gridMax(out.pq, grid);
  if (!(reach < 1e280)) return out;
  out.determinant = det.value;
  out.determinant_error = det.error;
  out.orientation = sign;
  return out;
}

ProjectedTriangle projectTriangle(const CellVertex& p, const CellVertex& q, const CellVertex& r,
                                  const CellVertexError& error, const GridSize& grid,
                                  const OrientedTriangle& oriented) noexcept {
  ProjectedTriangle t;
  const std::array<const CellVertex*, 3> vertex{&p, &q, &r};
  setCells(t, vertex, error, grid);
  if (!t.on_grid) return t;
  const int orientation = oriented.orientation;
  const std::array<EdgeLine, 3> edges{oriented.pq, oriented.qr, oriented.rp};
  for (std::size_t e = 0; e < 3; ++e) {
    t.sides[e] =
        sideLine(edges[e].a, edges[e].b, edges[e].c, gridError(edges[e], grid), grid, orientation);
  }
  const std::array<EdgeLine, 3> opposite{oriented.qr, oriented.rp, oriented.pq};
  const Determinant det{oriented.determinant, oriented.determinant_error};
  setDepth(t, vertex, opposite, det, error, grid);
  addCut(t, opposite, {p.near_cut, q.near_cut, r.near_cut}, error.near_cut, grid, orientation);
  addCut(t, opposite, {p.far_cut, q.far_cut, r.far_cut}, error.far_cut, grid, orientation);
  return t;
}

}  // namespace culld
