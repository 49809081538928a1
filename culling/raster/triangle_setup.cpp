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
constexpr SideLine kUnusable{0.0, 0.0, 0.0, std::numeric_limits<double>::infinity()};

double gridError(const EdgeLine& line, const GridSize& g) {
  return line.error_a * g.width + line.error_b * g.height + line.error_c;
}

double gridMax(const EdgeLine& line, const GridSize& g) {
  return std::abs(line.a) * g.width + std::abs(line.b) * g.height + std::abs(line.c);
}

/// The direction of an edge, q - p, and bounds on its errors.
struct EdgeVector {
  double u, v, w;
  double error_u, error_v, error_w;
};

EdgeVector between(const CellVertex& p, const CellVertex& q, const CellVertexError& e) {
  return {q.u - p.u, q.v - p.v, q.w - p.w, 2.0625 * e.u, 2.0625 * e.v, 2.0625 * e.w};
}

using Vector = std::array<double, 3>;  ///< in the scene

/// `line` as a vector of the scene, times the radius.
Vector inScene(const EdgeLine& line, const EyeMotion& m) {
  Vector x;
  for (std::size_t i = 0; i < 3; ++i) x[i] = line.a * m.u[i] + line.b * m.v[i] + line.c * m.w[i];
  return x;
}

double dot(const Vector& x, const Vector& y) { return x[0] * y[0] + x[1] * y[1] + x[2] * y[2]; }

/// At least the length of inScene(): how far `line` changes at a vertex that moves. The rows and
/// the sums make fewer than 16 roundings.
double mostChange(const EdgeLine& line, const Vector& in_scene, const EyeMotion& m) {
  const double squares = dot(in_scene, in_scene);
  const double length = squares > 1e-280
                            ? std::sqrt(squares)
                            : std::abs(in_scene[0]) + std::abs(in_scene[1]) + std::abs(in_scene[2]);
  return 1.01 * ((line.error_a + 16.0 * kUnit * std::abs(line.a)) * m.u_length +
                 (line.error_b + 16.0 * kUnit * std::abs(line.b)) * m.v_length +
                 (line.error_c + 16.0 * kUnit * std::abs(line.c)) * m.w_length) +
         (1.0 + 0x1p-48) * length;
}

/// l x t and bounds on its errors; t is exact.
EdgeLine crossed(const EdgeVector& l, const Vector& t) {
  const auto error = [](double x, double error_x, double other) {
    return (error_x + 4.0 * kUnit * std::abs(x)) * std::abs(other);
  };
  return {l.v * t[2] - l.w * t[1],
          l.w * t[0] - l.u * t[2],
          l.u * t[1] - l.v * t[0],
          error(l.v, l.error_v, t[2]) + error(l.w, l.error_w, t[1]),
          error(l.w, l.error_w, t[0]) + error(l.u, l.error_u, t[2]),
          error(l.u, l.error_u, t[1]) + error(l.v, l.error_v, t[0])};
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
  const EdgeLine normal = lineThrough(pq, pr, twice);
  return mostChange(normal, inScene(normal, e.motion), e.motion);
}

/// The unscaled line as a half-plane with the triangle on its positive side.
SideLine sideLine(double a, double b, double c, double error, const GridSize& g, int orientation) {
  const double length = std::abs(a) + std::abs(b);
  const double scale = static_cast<double>(orientation) / length;
  SideLine side{a * scale, b * scale, c * scale, 0.0};
  side.error = 1.01 * error / length + 8.0 * kUnit * (g.width + g.height + std::abs(side.c));
  const bool usable = length > kTiny && std::isfinite(side.a) && std::isfinite(side.b) &&
                      std::isfinite(side.c) && side.usable();
  if (!usable) return kUnusable;
  return side;
}

/// `line` is the side's, unscaled, and `along` its direction. By docs/error-model/motion.md §2 with
/// the plane through the edge that is farthest from the eye.
void addSway(SideLine& side, const EdgeLine& line, const EdgeVector& along, const EyeMotion& m,
             const GridSize& g) {
  if (!side.usable()) return;
  const Vector x = inScene(line, m);
  const Vector t{dot(m.u, x), dot(m.v, x), dot(m.w, x)};
  const EdgeLine plane = crossed(along, t);
  const double at_edge = line.a * t[0] + line.b * t[1] + line.c * t[2];
  const double lost = (line.error_a + 4.0 * kUnit * std::abs(line.a)) * std::abs(t[0]) +
                      (line.error_b + 4.0 * kUnit * std::abs(line.b)) * std::abs(t[1]) +
                      (line.error_c + 4.0 * kUnit * std::abs(line.c)) * std::abs(t[2]);
  const double least =
      (1.0 - 8.0 * kUnit) * at_edge - 1.01 * (lost + mostChange(plane, inScene(plane, m), m));
  const double scale = (1.0 + 0x1p-48) * mostChange(line, x, m) /
                       (std::max(least, 0.0) * (std::abs(line.a) + std::abs(line.b)));
  const double reach = (std::abs(plane.a) * (g.width + kBlockReach) +
                        std::abs(plane.b) * (g.height + kBlockReach) + std::abs(plane.c));
  side.sway_a = plane.a * scale;
  side.sway_b = plane.b * scale;
  side.sway_c =
      plane.c * scale + 1.01 *
                            (gridError(plane, {g.width + kBlockReach, g.height + kBlockReach}) +
                             16.0 * kUnit * reach) *
                            scale;
  if (std::isfinite(reach * scale) && std::isfinite(side.sway_c)) return;
  side.sway_a = side.sway_b = 0.0;
  side.sway_c = std::numeric_limits<double>::infinity();
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

/// Of a cut: its line's component errors and its direction, for its sway.
struct CutEdge {
  EdgeLine line;
  EdgeVector along;
};

CutEdge cutEdge(const Combined& sum, const std::array<EdgeLine, 3>& opposite,
                const std::array<EdgeVector, 3>& along, const std::array<double, 3>& k,
                double k_error) {
  CutEdge cut{{sum.a, sum.b, sum.c, 0.0, 0.0, 0.0}, {0.0, 0.0, 0.0, 0.0, 0.0, 0.0}};
  for (std::size_t i = 0; i < 3; ++i) {
    const EdgeLine& o = opposite[i];
    const EdgeVector& l = along[i];
    const double reach = std::abs(k[i]) + k_error, lost = k_error + 8.0 * kUnit * std::abs(k[i]);
    cut.line.error_a += 1.01 * (o.error_a * reach + std::abs(o.a) * lost);
    cut.line.error_b += 1.01 * (o.error_b * reach + std::abs(o.b) * lost);
    cut.line.error_c += 1.01 * (o.error_c * reach + std::abs(o.c) * lost);
    cut.along.u += l.u * k[i];
    cut.along.v += l.v * k[i];
    cut.along.w += l.w * k[i];
    cut.along.error_u += 1.01 * (l.error_u * reach + std::abs(l.u) * lost);
    cut.along.error_v += 1.01 * (l.error_v * reach + std::abs(l.v) * lost);
    cut.along.error_w += 1.01 * (l.error_w * reach + std::abs(l.w) * lost);
  }
  return cut;
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
              const std::array<EdgeLine, 3>& opposite, const OrientedTriangle& oriented,
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
  const DepthPlane plane =
      farthestPlane(sum, {oriented.determinant, oriented.determinant_error}, e.n, g);
  if (!plane.known) return;
  t.depth_a = plane.a;
  t.depth_b = plane.b;
  t.depth_c = plane.c;
}

void addCut(ProjectedTriangle& t, const std::array<const CellVertex*, 3>& vertex,
            const std::array<EdgeLine, 3>& opposite, const std::array<double, 3>& k, double k_error,
            const CellVertexError& e, const GridSize& g, int orientation) {
  if (std::min({k[0], k[1], k[2]}) > 2.0 * k_error) return;  // wholly on the visible side
  const Combined sum = combine(opposite, k, k_error, g);
  SideLine& side = t.sides[t.side_count++];
  side = sideLine(sum.a, sum.b, sum.c, sum.error, g, orientation);
  if (e.motion.still) return;
  const std::array<EdgeVector, 3> along{between(*vertex[1], *vertex[2], e),
                                        between(*vertex[2], *vertex[0], e),
                                        between(*vertex[0], *vertex[1], e)};
  const CutEdge cut = cutEdge(sum, opposite, along, k, k_error);
  addSway(side, cut.line, cut.along, e.motion, g);
}

/// Clamped cell range of [low, high]; false if it misses [0, side].
bool cellRange(double low, double high, double side, std::uint32_t& first, std::uint32_t& last) {
  if (high < 0.0 || low > side) return false;
  const double top = side - 1.0;
  first = static_cast<std::uint32_t>(low > 0.0 ? std::min(low, top) : 0.0);
  last = static_cast<std::uint32_t>(high < top ? std::max(high, 0.0) : top);
  return true;
}

/// Grows by places on the image.
struct Places {
  double u0 = 0.0, u1 = 0.0, v0 = 0.0, v1 = 0.0;
  bool none = true, bounded = true;

  void grow(double u, double u_error, double v, double v_error) {
    u0 = none ? u - u_error : std::min(u0, u - u_error);
    u1 = none ? u + u_error : std::max(u1, u + u_error);
    v0 = none ? v - v_error : std::min(v0, v - v_error);
    v1 = none ? v + v_error : std::max(v1, v + v_error);
    none = false;
  }
  bool cells(const GridSize& g, std::uint32_t& x0, std::uint32_t& x1, std::uint32_t& y0,
             std::uint32_t& y1) const {
    if (!bounded)
      return cellRange(0.0, g.width, g.width, x0, x1) && cellRange(0.0, g.height, g.height, y0, y1);
    return cellRange(u0, u1, g.width, x0, x1) && cellRange(v0, v1, g.height, y0, y1);
  }
};

/// At least how far motion carries a vertex over the image: |row - at * w row| / least w, where
/// `row` is that of u or v and `at` the vertex's place on it. docs/error-model/motion.md.
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
  Places still, moved;
  bool any_in_front = false, any_moved_in_front = false;
  for (const CellVertex* p : vertex) {
    any_in_front = any_in_front || p->w > -e.w;
    any_moved_in_front = any_moved_in_front || p->w > -(e.w + e.motion.w_length);
    const double least_w = p->w - e.w;
    if (!(least_w > 0.5 * std::abs(p->w)) || !(least_w > kTiny)) {
      still.bounded = moved.bounded = false;
      continue;
    }
    const double u = p->u / p->w, v = p->v / p->w;
    const double eu = 1.01 * (e.u + std::abs(u) * e.w) / least_w + 4.0 * kUnit * std::abs(u) + 1e-9;
    const double ev = 1.01 * (e.v + std::abs(v) * e.w) / least_w + 4.0 * kUnit * std::abs(v) + 1e-9;
    still.grow(u, eu, v, ev);
    if (!t.moving || !moved.bounded) continue;
    const double least_moved = least_w - e.motion.w_length;
    if (!(least_moved > 0x1p-20 * least_w) || !(least_moved > kTiny)) {
      moved.bounded = false;
      continue;
    }
    const double nearer = 1.01 * (1.0 + e.motion.w_length / least_moved);
    moved.grow(u, eu * nearer + carried(e.motion.u, e.motion.u_length, u, least_moved, e.motion), v,
               ev * nearer + carried(e.motion.v, e.motion.v_length, v, least_moved, e.motion));
  }
  t.on_grid = any_in_front && still.cells(g, t.cell_x0, t.cell_x1, t.cell_y0, t.cell_y1);
  t.reaches_grid = t.moving && any_moved_in_front &&
                   moved.cells(g, t.reach_x0, t.reach_x1, t.reach_y0, t.reach_y1);
}

}  // namespace

OrientedTriangle orientTriangle(const CellVertex& p, const CellVertex& q, const CellVertex& r,
                                const CellVertexError& error, const GridSize& grid,
                                int wanted) noexcept {
  OrientedTriangle out;
  out.qr = lineThrough(q, r, error);
  const Determinant det = determinant(p, out.qr, error);
  const double sway = error.motion.still ? 0.0 : determinantSway(p, q, r, error);
  const double size = std::abs(det.value);
  // Both bounds fail for NaN and infinity: such a triangle is not used.
  if (!(size > det.error + sway + kTiny) || !(size < 1e280)) return out;
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
  if (!t.on_grid && !t.reaches_grid) return t;
  const int orientation = oriented.orientation;
  const std::array<EdgeLine, 3> edges{oriented.pq, oriented.qr, oriented.rp};
  for (std::size_t e = 0; e < 3; ++e) {
    t.sides[e] = sideOf(*vertex[e], *vertex[(e + 1) % 3], edges[e], error, grid, orientation);
  }
  const std::array<EdgeLine, 3> opposite{oriented.qr, oriented.rp, oriented.pq};
  setDepth(t, vertex, opposite, oriented, error, grid);
  addCut(t, vertex, opposite, {p.near_cut, q.near_cut, r.near_cut}, error.near_cut, error, grid,
         orientation);
  addCut(t, vertex, opposite, {p.far_cut, q.far_cut, r.far_cut}, error.far_cut, error, grid,
         orientation);
  return t;
}

SideLine sideOf(const CellVertex& p, const CellVertex& q, const EdgeLine& line,
                const CellVertexError& error, const GridSize& grid, int orientation) noexcept {
  SideLine side = sideLine(line.a, line.b, line.c, gridError(line, grid), grid, orientation);
  if (!error.motion.still) addSway(side, line, between(p, q, error), error.motion, grid);
  return side;
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
