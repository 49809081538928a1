#include "culling/occluders/volume_eye.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace culld {
namespace {

constexpr double kUp = 1.0 + 1e-9;

/// Unit vectors to the image's corners, in order around it.
std::array<glm::dvec3, 4> cornerDirections(const Camera& camera) {
  constexpr std::array<std::array<double, 2>, 4> kPlaces{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
  const glm::dvec3 x(camera.x_row), y(camera.y_row), w(camera.w_row);
  std::array<glm::dvec3, 4> corners;
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec3 along = glm::cross(x - kPlaces[i][0] * w, y - kPlaces[i][1] * w);
    const double length = glm::dot(w, along) < 0.0 ? -glm::length(along) : glm::length(along);
    corners[i] = along / length;
  }
  return corners;
}

/// The distance from which on a clip plane of any pose cuts nothing on the image. Infinite: it may
/// cut anything.
double clearOf(const glm::dvec4& row, const std::array<glm::dvec3, 4>& corners) {
  if (row.w >= 0.0) return 0.0;  // what it cuts is cut for good, and all behind that as well
  double least = std::numeric_limits<double>::infinity();
  for (const glm::dvec3& c : corners) least = std::min(least, glm::dot(glm::dvec3(row), c));
  const bool sure = least > 1e-6 * glm::length(glm::dvec3(row));  // NaN is not
  return sure ? kUp * (1.0 + 1e-6) * -row.w / least : std::numeric_limits<double>::infinity();
}

double vectorArea(const std::array<glm::dvec3, 4>& corners) {
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i < 4; ++i) sum += glm::cross(corners[i], corners[(i + 1) % 4]);
  return 0.5 * glm::length(sum);
}

void setOrthographic(const Camera& camera, VolumeEye& eye) {
  const glm::dvec3 x(camera.x_row), y(camera.y_row);
  const glm::dvec3 along = glm::cross(x, y);
  const double length = glm::length(along);
  const double sign = glm::dot(along, glm::dvec3(camera.near_row)) < 0.0 ? 1.0 : -1.0;
  eye.along = sign / length * along;
  eye.along_error = 0x1p-49 * glm::length(x) * glm::length(y) / length + 0x1p-49;
  eye.cut_row[0] = camera.near_cut_row;
  eye.cut_row[1] = camera.far_cut_row;
  eye.cut_radius_m = kUp * camera.motion.radius_m;
  eye.image = 4.0 / length;
  if (camera.motion.angle_rad > 0.0) eye.why_not = "an orthographic camera that turns";
  if (!(eye.along_error < 1e-6)) eye.why_not = "the camera's rays have no certain direction";
}

}  // namespace

VolumeEye volumeEye(const Camera& camera) noexcept {
  VolumeEye eye;
  eye.origin_world = camera.origin_world;
  eye.perspective = camera.perspective;
  if (!camera.perspective) {
    setOrthographic(camera, eye);
    return eye;
  }
  const std::array<glm::dvec3, 4> corners = cornerDirections(camera);
  eye.radius_m = kUp * camera.motion.radius_m;
  eye.near_m =
      std::max(clearOf(camera.near_cut_row, corners), clearOf(camera.far_cut_row, corners));
  eye.image = vectorArea(corners);
  if (!std::isfinite(eye.near_m)) eye.why_not = "a clip plane may cut away any blocker";
  return eye;
}

}  // namespace culld
