#include "client/cli/motion.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace culld::client {
namespace {

using Vec = std::array<double, 3>;

Vec minus(const Vec& a, const Vec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }

double length(const Vec& v) { return std::hypot(v[0], v[1], v[2]); }

Vec unit(const Vec& v) {
  const double l = length(v);
  return l > 0.0 ? Vec{v[0] / l, v[1] / l, v[2] / l} : v;
}

Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

Pose poseOf(const protocol::LookAt& look) {
  const Vec back = unit(minus(look.eye, look.target));
  const Vec right = unit(cross(look.up, back));
  const Vec up = cross(back, right);
  Pose pose;
  pose.eye = look.eye;
  pose.rotation = {right[0], right[1], right[2], up[0], up[1], up[2], back[0], back[1], back[2]};
  return pose;
}

/// `view` maps p to R p + t, column by column; the eye is where that is zero.
Pose poseOf(const protocol::Matrices& matrices) {
  const auto& m = matrices.view;
  Pose pose;
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t column = 0; column < 3; ++column) {
      pose.rotation[3 * row + column] = m[4 * column + row];
      pose.eye[column] -= m[4 * column + row] * m[12 + row];
    }
  }
  return pose;
}

}  // namespace

Pose poseOf(const protocol::Camera& camera) {
  return std::visit([](const auto& pose) { return poseOf(pose); }, camera.pose);
}

bool withinBound(const Pose& pose, const Pose& centre, double radius_m, double angle_rad) {
  if (length(minus(pose.eye, centre.eye)) > radius_m) return false;
  double trace = 0.0;
  for (std::size_t i = 0; i < 9; ++i) trace += pose.rotation[i] * centre.rotation[i];
  // Rounding leaves acos() of a pose with itself a little above 0.
  constexpr double kRounding = 1e-7;
  return std::acos(std::clamp((trace - 1.0) / 2.0, -1.0, 1.0)) <= angle_rad + kRounding;
}

}  // namespace culld::client
