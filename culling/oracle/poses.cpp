#include "culling/oracle/poses.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <numbers>

#include "culling/oracle/aim.h"

namespace culld::oracle {
namespace {

constexpr std::uint64_t kForPoses = 4;
constexpr double kInside = 1.0 - 1e-9;  // of the bound: rounding must not leave it

double largest(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

glm::dvec3 unit(const glm::dvec4& row) {
  const glm::dvec3 v = glm::dvec3(row) / largest(glm::dvec3(row));
  return v / glm::length(v);
}

/// How a pose differs from the camera's own.
struct Motion {
  glm::dvec3 shift_m{0.0};
  glm::dvec3 axis{0.0, 0.0, 1.0};
  double angle_rad = 0.0;
};

class PoseMaker {
 public:
  PoseMaker(const Camera& camera, std::uint64_t seed)
      : camera_(camera), random_(seed, kForPoses, 0) {
    const glm::dvec3 right = unit(camera.x_row), up = unit(camera.y_row);
    ahead_ = camera.perspective ? unit(camera.w_row) : -unit(camera.near_row);
    ways_ = {right, -right, up, -up, ahead_, -ahead_};
    radius_m_ =
        std::max(0.0, camera.motion.radius_m * kInside - 0x1p-50 * largest(camera.origin_world));
    const double angle = std::min(camera.motion.angle_rad, std::numbers::pi);
    angle_rad_ = std::max(0.0, angle * kInside - 0x1p-50);
  }

  /// Number 0 is the first that differs from the camera's own.
  Camera pose(std::uint32_t number) {
    return moved(number < ways_.size() ? extreme(ways_[number]) : any(number));
  }

 private:
  Motion extreme(const glm::dvec3& way) const {
    const glm::dvec3 axis = glm::cross(ahead_, way);  // turns what is ahead towards `way`
    const double length = glm::length(axis);
    return {radius_m_ * way, length > 1e-6 ? axis / length : way, angle_rad_};
  }

  Motion any(std::uint32_t number) {
    Motion motion;
    motion.shift_m = radius_m_ * direction();
    if (number % 2 != 0) motion.shift_m *= std::cbrt(random_.unit());
    motion.axis = direction();
    motion.angle_rad = number % 3 != 0 ? angle_rad_ : angle_rad_ * random_.unit();
    return motion;
  }

  /// Even over the sphere (Archimedes).
  glm::dvec3 direction() {
    const double z = 2.0 * random_.unit() - 1.0;
    const double around = 2.0 * std::numbers::pi * random_.unit();
    const double across = std::sqrt(std::max(0.0, 1.0 - z * z));
    return {across * std::cos(around), across * std::sin(around), z};
  }

  Camera moved(const Motion& motion) const {
    Camera camera = camera_;
    camera.motion = {};
    camera.origin_world += motion.shift_m;
    const glm::dmat3 turn(glm::rotate(glm::dmat4(1.0), motion.angle_rad, motion.axis));
    for (glm::dvec4* row : {&camera.x_row, &camera.y_row, &camera.z_row, &camera.w_row,
                            &camera.near_row, &camera.near_cut_row, &camera.far_cut_row}) {
      *row = glm::dvec4(turn * glm::dvec3(*row), row->w);
    }
    return camera;
  }

  const Camera& camera_;
  Random random_;
  glm::dvec3 ahead_{0.0};
  std::array<glm::dvec3, 6> ways_{};
  double radius_m_ = 0.0, angle_rad_ = 0.0;
};

}  // namespace

std::vector<Camera> posesWithin(const Camera& camera, std::uint32_t further, std::uint64_t seed) {
  std::vector<Camera> poses{camera};
  poses[0].motion = {};
  if (camera.motion.still()) return poses;
  PoseMaker maker(camera, seed);
  for (std::uint32_t number = 0; number < further; ++number) poses.push_back(maker.pose(number));
  return poses;
}

}  // namespace culld::oracle
