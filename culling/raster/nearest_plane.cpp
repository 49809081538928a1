#include "culling/raster/nearest_plane.h"

namespace culld {

NearestPlane nearestPlane(const std::array<CellVertex, 3>& p, const CellVertexError& e,
                          const GridSize& g, const OrientedTriangle& t, float ceiling) noexcept {
  constexpr double kUnit = 0x1p-53;
  const std::array<const EdgeLine*, 3> opposite{&t.qr, &t.rp, &t.pq};
  double a = 0.0, b = 0.0, c = 0.0, error = 0.0, terms = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const EdgeLine& line = *opposite[i];
    const double n = p[i].n, size = std::abs(n);
    a += line.a * n;
    b += line.b * n;
    c += line.c * n;
    error += size * (line.error_a * g.width + line.error_b * g.height + line.error_c);
    terms += size * (std::abs(line.a) * g.width + std::abs(line.b) * g.height + std::abs(line.c));
  }
  const double scale = (t.determinant > 0.0 ? 1.0 : -1.0) * (1.0 + 8.0 * kUnit) /
                       (std::abs(t.determinant) - t.determinant_error);
  NearestPlane out;
  out.ceiling = ceiling;
  a *= scale;
  b *= scale;
  c *= scale;
  const double reach = std::abs(a) * g.width + std::abs(b) * g.height + std::abs(c);
  c += 1.01 * ((error + 16.0 * kUnit * terms) * std::abs(scale) + e.n) + 16.0 * kUnit * reach;
  if (!std::isfinite(reach) || !std::isfinite(c)) return out;
  out.a = a;
  out.b = b;
  out.c = c;
  return out;
}

}  // namespace culld
