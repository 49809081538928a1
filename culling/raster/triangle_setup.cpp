#include "culling/raster/triangle_setup.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace culld {

EdgeLine lineThrough(const CellVertex& p, const CellVertex& q, const CellVertexError& e) noexcept {
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

namespace {

constexpr double kUnit = 0x1p-53;    ///< half an ulp of 1
constexpr double kTiny = 1e-280;     ///< below this, underflow could exceed the error bounds
constexpr double kBlockReach = 8.0;  ///< cells by which the last blocks may stick out of the grid
constexpr SideLine kUnusable{0.0, 0.0, 0.0, std::numeric_limits<double>::infinity(), 0.0};

double gridError(const EdgeLine& line, const GridSize& g) {
  return line.error_a * g.width + line.error_b * g.height + line.error_c;
}

double gridMax(const EdgeLine& line, const GridSize& g) {
  return std::abs(line.a) * g.width + std::abs(line.b) * g.height + std::abs(line.c);
}

/// At least the change of `line` at any vertex that moves with the eye: |line . (u, v, w) d| over
/// all |d| <= radius. The rows and the sums below make fewer than 16 roundings.
double swayOf(const EdgeLine& line, const EyeMotion& m) {
  double sum = 0.0, squares = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double x = line.a * m.u[axis] + line.b * m.v[axis] + line.c * m.w[axis];
    sum += std::abs(x);
    squares += x * x;
  }
  const double length = squares > 1e-280 ? std::sqrt(squares) : sum;
  return 1.01 * ((line.error_a + 16.0 * kUnit * std::abs(line.a)) * m.u_length +
                 (line.error_b + 16.0 * kUnit * std::abs(line.b)) * m.v_length +
                 (line.error_c + 16.0 * kUnit * std::abs(line.c)) * m.w_length) +
         (1.0 + 0x1p-48) * length;
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

/// How far motion may change the determinant: by the triangle's normal, made from the vertices'
/// differences, which lose less than the sum of its lines.
double determinantSway(const CellVertex& p, const CellVertex& q, const CellVertex& r,
                       const CellVertexError& e) {
  const CellVertex pq{q.u - p.u, q.v - p.v, q.w - p.w, 0.0, 0.0, 0.0};
  const CellVertex pr{r.u - p.u, r.v - p.v, r.w - p.w, 0.0, 0.0, 0.0};
  const CellVertexError twice{2.0 * e.u, 2.0 * e.v, 2.0 * e.w, 0.0, 0.0, 0.0, {}};
  return swayOf(lineThrough(pq, pr, twice), e.motion);
}

/// The unscaled line as a half-plane with the triangle on its positive side.
SideLine sideLine(double a, double b, double c, double error, const GridSize& g, int orientation) {
  const double length = std::abs(a) + std::abs(b);
  const double scale = static_cast<double>(orientation) / length;
  SideLine side{a * scale, b * scale, c * scale, 0.0, 0.0};
  side.error = 1.01 * error / length + 8.0 * kUnit * (g.width + g.height + std::abs(side.c));
  const bool usable = length > kTiny && std::isfinite(side.a) && std::isfinite(side.b) &&
                      std::isfinite(side.c) && side.usable();
  if (!usable) return kUnusable;
  return side;
}

/// In motion. `line` is the side's, unscaled, with its errors.
void addSway(SideLine& side, const EdgeLine& line, const EyeMotion& motion) {
  if (!side.usable()) return;
  side.sway = (1.0 + 0x1p-48) * swayOf(line, motion) / (std::abs(line.a) + std::abs(line.b));
  if (!std::isfinite(side.sway)) side = kUnusable;
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

/// The component errors of a combined line, for its sway.
EdgeLine withErrors(const Combined& sum, const std::array<EdgeLine, 3>& opposite,
                    const std::array<double, 3>& k, double k_error) {
  EdgeLine line{sum.a, sum.b, sum.c, 0.0, 0.0, 0.0};
  for (std::size_t i = 0; i < 3; ++i) {
    const EdgeLine& o = opposite[i];
    const double reach = std::abs(k[i]) + k_error, lost = k_error + 8.0 * kUnit * std::abs(k[i]);
    line.error_a += 1.01 * (o.error_a * reach + std::abs(o.a) * lost);
    line.error_b += 1.01 * (o.error_b * reach + std::abs(o.b) * lost);
    line.error_c += 1.01 * (o.error_c * reach + std::abs(o.c) * lost);
  }
  return line;
}

/// In motion: the plane that nearness does not exceed. `sum` is the numerator of nearness.
void setNearest(ProjectedTriangle& t, const Combined& sum, const Determinant& det,
                const GridSize& g) {
  const double sign = det.value > 0.0 ? 1.0 : -1.0;
  const double scale = sign * (1.0 + 8.0 * kUnit) / (std::abs(det.value) - det.error);
  t.nearest_a = sum.a * scale;
  t.nearest_b = sum.b * scale;
  t.nearest_c = sum.c * scale;
  const double reach = std::abs(t.nearest_a) * (g.width + kBlockReach) +
                       std::abs(t.nearest_b) * (g.height + kBlockReach) + std::abs(t.nearest_c);
  t.nearest_c += 1.01 * sum.error * std::abs(scale) + 8.0 * kUnit * reach;
  if (std::isfinite(reach) && std::isfinite(t.nearest_c)) return;
  t.nearest_a = t.nearest_b = 0.0;
  t.nearest_c = std::numeric_limits<double>::infinity();
}

/// The plane that nearness does not fall below. `sum` is the numerator of nearness.
DepthPlane farthestPlane(const Combined& sum, const Determinant& det, double n_error,
                         const GridSize& g) {
  const double sign = det.value > 0.0 ? 1.0 : -1.0;
  const double scale = sign * (1.0 - 8.0 * kUnit) / (std::abs(det.value) + det.error);
  const double a = sum.a * scale, b = sum.b * scale, c = sum.c * scale;
  const double rounding =
      8.0 * kUnit * (std::abs(a) * g.width + std::abs(b) * g.height + std::abs(c));
  const double loss = 1.01 * (sum.error * std::abs(scale) + n_error) + rounding;
  if (!std::isfinite(a) || !std::isfinite(b) || !std::isfinite(c - loss)) return {};
  return {a, b, c - loss, true};
}

void setDepth(ProjectedTriangle& t, const std::array<const CellVertex*, 3>& vertex,
              const std::array<EdgeLine, 3>& opposite, const Determinant& det,
              const CellVertexError& e, const GridSize& g) {
  double floor = std::numeric_limits<double>::infinity();
  const double moved_w = e.w + e.motion.w_length;
  for (const CellVertex* p : vertex) {
    if (!(p->w > -moved_w)) continue;  // behind the eye: the visible part is nearer than the others
    const double n = p->n - e.n;
    floor = std::min(floor, n / (n >= 0.0 ? p->w + moved_w : p->w - moved_w));
  }
  floor -= 4.0 * kUnit * std::abs(floor);
  t.depth_floor = floor;
  t.depth_a = t.depth_b = 0.0;
  t.depth_c = floor;
  const std::array<double, 3> n{vertex[0]->n, vertex[1]->n, vertex[2]->n};
  // The vertex errors of n are constant over the triangle (docs/error-model.md §4.5): added below.
  const Combined sum = combine(opposite, n, 0.0, g);
  if (!e.motion.still) setNearest(t, sum, det, g);
  const DepthPlane plane = farthestPlane(sum, det, e.n, g);
  if (!plane.known) return;
  t.depth_a = plane.a;
  t.depth_b = plane.b;
  t.depth_c = plane.c;
}

void addCut(ProjectedTriangle& t, const std::array<EdgeLine, 3>& opposite,
            const std::array<double, 3>& k, double k_error, const EyeMotion& motion,
            const GridSize& g, int orientation) {
  if (std::min({k[0], k[1], k[2]}) > 2.0 * k_error) return;  // wholly on the visible side
  const Combined sum = combine(opposite, k, k_error, g);
  SideLine& side = t.sides[t.side_count++];
  side = sideLine(sum.a, sum.b, sum.c, sum.error, g, orientation);
  if (!motion.still) addSway(side, withErrors(sum, opposite, k, k_error), motion);
}

/// Clamped cell range of [low, high]; false if it misses [0, side].
bool cellRange(double low, double high, double side, std::uint32_t& first, std::uint32_t& last) {
  if (high < 0.0 || low > side) return false;
  const double top = side - 1.0;
  first = static_cast<std::uint32_t>(low > 0.0 ? std::min(low, top) : 0.0);
  last = static_cast<std::uint32_t>(high < top ? std::max(high, 0.0) : top);
  return true;
}

/// At least how far motion carries a vertex over the image: |row - at * w row| / least w, where
/// `row` is that of u or v and `at` the vertex's place on it. docs/error-model.md §7.
double carried(const std::array<double, 3>& row, double row_length, double at, double least_w,
               const EyeMotion& m) {
  double squares = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double x = row[axis] - at * m.w[axis];
    squares += x * x;
  }
  return (1.01 * std::sqrt(squares) + 0x1p-40 * (row_length + std::abs(at) * m.w_length)) / least_w;
}

void setCells(ProjectedTriangle& t, const std::array<const CellVertex*, 3>& vertex,
              const CellVertexError& e, const GridSize& g) {
  double u0 = g.width, u1 = 0.0, v0 = g.height, v1 = 0.0;
  bool bounded = true, any_in_front = false;
  bool first = true;
  for (const CellVertex* p : vertex) {
    any_in_front = any_in_front || p->w > -(e.w + e.motion.w_length);
    const double least_w = p->w - e.w;
    const double least_moved = least_w - e.motion.w_length;
    if (!(least_w > 0.5 * std::abs(p->w)) || !(least_moved > 0x1p-20 * least_w) ||
        !(least_moved > kTiny)) {
      bounded = false;
      continue;
    }
    const double u = p->u / p->w, v = p->v / p->w;
    double eu = 1.01 * (e.u + std::abs(u) * e.w) / least_w + 4.0 * kUnit * std::abs(u) + 1e-9;
    double ev = 1.01 * (e.v + std::abs(v) * e.w) / least_w + 4.0 * kUnit * std::abs(v) + 1e-9;
    if (!e.motion.still) {
      const double nearer = 1.01 * (1.0 + e.motion.w_length / least_moved);
      eu = eu * nearer + carried(e.motion.u, e.motion.u_length, u, least_moved, e.motion);
      ev = ev * nearer + carried(e.motion.v, e.motion.v_length, v, least_moved, e.motion);
    }
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
  Determinant det = determinant(p, out.qr, error);
  if (!error.motion.still) det.error += determinantSway(p, q, r, error);
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
  t.moving = !error.motion.still;
  const std::array<const CellVertex*, 3> vertex{&p, &q, &r};
  setCells(t, vertex, error, grid);
  if (!t.on_grid) return t;
  const int orientation = oriented.orientation;
  const std::array<EdgeLine, 3> edges{oriented.pq, oriented.qr, oriented.rp};
  for (std::size_t e = 0; e < 3; ++e) {
    t.sides[e] =
        sideLine(edges[e].a, edges[e].b, edges[e].c, gridError(edges[e], grid), grid, orientation);
    if (!error.motion.still) addSway(t.sides[e], edges[e], error.motion);
  }
  const std::array<EdgeLine, 3> opposite{oriented.qr, oriented.rp, oriented.pq};
  const Determinant det{oriented.determinant, oriented.determinant_error};
  setDepth(t, vertex, opposite, det, error, grid);
  addCut(t, opposite, {p.near_cut, q.near_cut, r.near_cut}, error.near_cut, error.motion, grid,
         orientation);
  addCut(t, opposite, {p.far_cut, q.far_cut, r.far_cut}, error.far_cut, error.motion, grid,
         orientation);
  return t;
}

SideLine sideOf(const EdgeLine& line, const GridSize& grid, int orientation) noexcept {
  return sideLine(line.a, line.b, line.c, gridError(line, grid), grid, orientation);
}

DepthPlane depthPlane(const CellVertex& p, const CellVertex& q, const CellVertex& r,
                      const CellVertexError& error, const GridSize& grid,
                      const OrientedTriangle& oriented) noexcept {
  const Combined sum = combine({oriented.qr, oriented.rp, oriented.pq}, {p.n, q.n, r.n}, 0.0, grid);
  return farthestPlane(sum, {oriented.determinant, oriented.determinant_error}, error.n, grid);
}

bool surelyPositive(const std::array<double, 3>& k, double k_error, const GridSize& grid,
                    const OrientedTriangle& oriented) noexcept {
  const Combined sum = combine({oriented.qr, oriented.rp, oriented.pq}, k, k_error, grid);
  const double o = oriented.orientation;
  const double least =
      o * sum.c + std::min(o * sum.a, 0.0) * grid.width + std::min(o * sum.b, 0.0) * grid.height;
  return least > 1.01 * sum.error;
}

}  // namespace culld
