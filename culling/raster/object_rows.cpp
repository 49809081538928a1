#include "culling/raster/object_rows.h"

#include <cmath>

namespace culld {
namespace {

struct BoundedRow {
  ObjectRow row;
  double error;
};

/// row . (world_from_mesh p - origin, 1) as a row on p. The 16 units of the error bound cover the
/// product (at most 9 roundings per term) and the four of its evaluation (docs/error-model.md
/// §4.1).
BoundedRow objectRow(const glm::dvec4& row, const std::array<double, 12>& m,
                     const glm::dvec3& offset, const glm::dvec3& largest) {
  const auto column = [&](std::size_t j) {
    return row.x * m[j] + row.y * m[4 + j] + row.z * m[8 + j];
  };
  const auto reach = [&](std::size_t j) {
    return std::abs(row.x * m[j]) + std::abs(row.y * m[4 + j]) + std::abs(row.z * m[8 + j]);
  };
  const double constant = row.x * offset.x + row.y * offset.y + row.z * offset.z + row.w;
  const double terms = reach(0) * largest.x + reach(1) * largest.y + reach(2) * largest.z +
                       std::abs(row.x * offset.x) + std::abs(row.y * offset.y) +
                       std::abs(row.z * offset.z) + std::abs(row.w);
  return {{column(0), column(1), column(2), constant}, 16.0 * 0x1p-53 * terms};
}

}  // namespace

ObjectRows objectRows(const CellView& view, const std::array<double, 12>& m,
                      const glm::dvec3& camera_origin_world, const glm::dvec3& largest) noexcept {
  const glm::dvec3 offset = glm::dvec3(m[3], m[7], m[11]) - camera_origin_world;
  const auto row = [&](const glm::dvec4& r) { return objectRow(r, m, offset, largest); };
  const BoundedRow u = row(view.u), v = row(view.v), w = row(view.w), n = row(view.n),
                   near_cut = row(view.near_cut), far_cut = row(view.far_cut);
  return {u.row,
          v.row,
          w.row,
          n.row,
          near_cut.row,
          far_cut.row,
          {u.error, v.error, w.error, view.perspective ? 0.0 : n.error, near_cut.error,
           far_cut.error, view.motion}};
}

/// Six products of three and five sums: 8 units cover them.
double handedness(const std::array<double, 12>& m) noexcept {
  const double a = m[0] * m[5] * m[10], b = m[1] * m[6] * m[8], c = m[2] * m[4] * m[9];
  const double d = m[2] * m[5] * m[8], e = m[1] * m[4] * m[10], f = m[0] * m[6] * m[9];
  const double det = (a + b + c) - (d + e + f);
  const double terms =
      std::abs(a) + std::abs(b) + std::abs(c) + std::abs(d) + std::abs(e) + std::abs(f);
  if (!(std::abs(det) > 8.0 * 0x1p-53 * terms + 1e-280)) return 0.0;
  return det > 0.0 ? 1.0 : -1.0;
}

}  // namespace culld
