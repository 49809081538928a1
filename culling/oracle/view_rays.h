// A camera turned inside out: from a place in its image to a ray, and from a point to its ray.
// All relative to Camera::origin_world, in double precision.
#pragma once
#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <optional>

#include "culling/core/camera.h"

namespace culld::oracle {

/// Points origin + t * direction with t_min < t < t_max are inside the open frustum.
/// Perspective: t is the clip w. Orthographic: t runs from 0 (near plane) to 1 (far plane).
struct Ray {
  glm::dvec3 origin{0.0};
  glm::dvec3 direction{0.0};
  double t_min = 0.0;
  double t_max = 0.0;
};

class ViewRays {
 public:
  explicit ViewRays(const Camera& camera);
  /// x and y in normalized device coordinates, within (-1, 1). None if nothing of it is in depth
  /// range.
  std::optional<Ray> through(double x, double y) const;
  struct Aimed {
    Ray ray;
    double t_target = 0.0;
  };
  /// None unless the point is inside the open frustum.
  std::optional<Aimed> at(const glm::dvec3& point) const;
  /// Normalized device coordinates. None behind the eye. Depth is not looked at.
  std::optional<glm::dvec2> imageOf(const glm::dvec3& point) const;
  /// True if no point centre + sum of s_i * axes[i], |s_i| <= 1, is inside. Doubt (NaN) gives
  /// false.
  bool outside(const glm::dvec3& centre, const std::array<glm::dvec3, 3>& axes) const;
  /// Largest coordinate of a ray's origin.
  double originReach() const { return origin_reach_; }
  bool perspective() const { return perspective_; }

 private:
  std::optional<Ray> clipped(const glm::dvec3& origin, const glm::dvec3& direction) const;

  bool perspective_ = true;
  glm::dvec4 x_row_, y_row_, w_row_;
  glm::dvec4 near_row_;                     // Camera::near_row
  std::array<glm::dvec4, 2> depth_planes_;  // inside: dot(plane, p) > 0
  std::array<glm::dvec4, 6> planes_;
  // Perspective: direction = corner_ + x * across_ + y * along_. Orthographic: origin likewise.
  glm::dvec3 corner_{0.0}, across_{0.0}, along_{0.0};
  glm::dvec3 depth_{0.0};  // orthographic: near plane to far plane
  double origin_reach_ = 0.0;
};

}  // namespace culld::oracle
