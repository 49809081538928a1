#include "culling/occluders/mesh_eye.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

#include "culling/core/sum_abs.h"
#include "culling/raster/object_rows.h"

namespace culld {
namespace {

constexpr double kUnit = 0x1p-53;
constexpr double kLeastShape = 1e-6;  ///< determinant, as a share of the rows' lengths
constexpr double kUp = 1.001;         ///< for the roundings of what bounds roundings

/// At least the spectral norm of the matrix with these columns: its Gram matrices' row sums bound
/// their eigenvalues (Gershgorin), and are exact for turned and scaled ones.
double mostGrowth(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const auto rowSums = [](const glm::dvec3& x, const glm::dvec3& y, const glm::dvec3& z) {
    const double xy = std::abs(glm::dot(x, y)), yz = std::abs(glm::dot(y, z));
    const double zx = std::abs(glm::dot(z, x));
    return std::max({glm::dot(x, x) + xy + zx, glm::dot(y, y) + xy + yz, glm::dot(z, z) + yz + zx});
  };
  const double of_rows = rowSums({a.x, b.x, c.x}, {a.y, b.y, c.y}, {a.z, b.z, c.z});
  return std::sqrt(std::min(rowSums(a, b, c), of_rows));
}

}  // namespace

std::optional<MeshEye> meshEye(const std::array<double, 12>& m, const VolumeEye& eye) noexcept {
  if (handedness(m) == 0.0) return std::nullopt;
  const glm::dvec3 a(m[0], m[1], m[2]), b(m[4], m[5], m[6]), c(m[8], m[9], m[10]);
  const glm::dvec3 bc = glm::cross(b, c), ca = glm::cross(c, a), ab = glm::cross(a, b);
  const double det = glm::dot(a, bc);
  const double size = glm::length(a) * glm::length(b) * glm::length(c);
  if (!(std::abs(det) > kLeastShape * size)) return std::nullopt;  // NaN is not
  const glm::dvec3 wanted =
      eye.perspective ? eye.origin_world - glm::dvec3(m[3], m[7], m[11]) : -eye.along;
  const double known_to = eye.perspective ? eye.radius_m : 2.0 * eye.along_error;
  MeshEye out;
  out.parallel = !eye.perspective;
  out.at = (wanted.x * bc + wanted.y * ca + wanted.z * ab) / det;
  // What the matrix makes of it is not quite what was wanted: the difference counts as motion.
  const glm::dvec3 reached(glm::dot(a, out.at), glm::dot(b, out.at), glm::dot(c, out.at));
  const double terms = sumAbs(wanted) + sumAbs(out.at) * (sumAbs(a) + sumAbs(b) + sumAbs(c));
  const double off = glm::length(reached - wanted) + 16.0 * kUnit * terms;
  out.radius = kUp * mostGrowth(bc, ca, ab) / std::abs(det) * (known_to + off);
  if (!std::isfinite(out.radius) || !std::isfinite(sumAbs(out.at))) return std::nullopt;
  return out;
}

}  // namespace culld
