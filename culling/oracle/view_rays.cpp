#include "culling/oracle/view_rays.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

namespace culld::oracle {
namespace {

// A point this close to a side of the frustum (relative) is left to the methods' rounding.
constexpr double kSideMargin = 1e-9;

double valueAt(const glm::dvec4& plane, const glm::dvec3& p) {
  return glm::dot(glm::dvec3(plane), p) + plane.w;
}

glm::dvec3 linear(const glm::dvec4& row) { return glm::dvec3(row); }

}  // namespace

ViewRays::ViewRays(const Camera& camera)
    : perspective_(camera.perspective),
      x_row_(camera.x_row),
      y_row_(camera.y_row),
      w_row_(camera.w_row),
      near_row_(camera.near_row),
      depth_planes_{camera.near_cut_row, camera.far_cut_row},
      planes_{camera.w_row + camera.x_row,
              camera.w_row - camera.x_row,
              camera.w_row + camera.y_row,
              camera.w_row - camera.y_row,
              depth_planes_[0],
              depth_planes_[1]} {
  const glm::dvec4& third = perspective_ ? w_row_ : near_row_;
  // The columns of the inverse of three rows; each row is scaled first, so that a telescope's
  // large rows and a planet's small ones do not drown each other.
  const double sx = glm::length(linear(x_row_)), sy = glm::length(linear(y_row_));
  const double st = glm::length(linear(third));
  const glm::dmat3 rows =
      glm::transpose(glm::dmat3(linear(x_row_) / sx, linear(y_row_) / sy, linear(third) / st));
  const glm::dmat3 inverse = glm::inverse(rows);
  across_ = inverse[0] / sx;
  along_ = inverse[1] / sy;
  if (perspective_) {
    corner_ = inverse[2] / st;
    return;
  }
  // x_row . p + x_row.w = x, likewise y, and nearness 1.
  corner_ = inverse * glm::dvec3(-x_row_.w / sx, -y_row_.w / sy, (1.0 - third.w) / st);
  depth_ = -inverse[2] / st;
  for (int i = 0; i < 3; ++i) {
    origin_reach_ =
        std::max(origin_reach_, std::abs(corner_[i]) + std::abs(across_[i]) + std::abs(along_[i]));
  }
}

std::optional<Ray> ViewRays::clipped(const glm::dvec3& origin, const glm::dvec3& direction) const {
  Ray ray{origin, direction, 0.0, std::numeric_limits<double>::infinity()};
  if (!perspective_) ray.t_min = -ray.t_max;
  for (const glm::dvec4& plane : depth_planes_) {
    const double start = valueAt(plane, origin);
    const double slope = glm::dot(glm::dvec3(plane), direction);
    if (slope > 0.0) {
      ray.t_min = std::max(ray.t_min, -start / slope);
    } else if (slope < 0.0) {
      ray.t_max = std::min(ray.t_max, -start / slope);
    } else if (!(start > 0.0)) {
      return std::nullopt;
    }
  }
  if (!(ray.t_min < ray.t_max)) return std::nullopt;
  return ray;
}

std::optional<Ray> ViewRays::through(double x, double y) const {
  const glm::dvec3 place = corner_ + x * across_ + y * along_;
  return perspective_ ? clipped(glm::dvec3(0.0), place) : clipped(place, depth_);
}

std::optional<ViewRays::Aimed> ViewRays::at(const glm::dvec3& point) const {
  const double w = valueAt(w_row_, point);
  if (!(w > 0.0)) return std::nullopt;
  const double side = w * (1.0 - kSideMargin);
  if (!(std::abs(valueAt(x_row_, point)) < side)) return std::nullopt;
  if (!(std::abs(valueAt(y_row_, point)) < side)) return std::nullopt;
  const double t = perspective_ ? w : 1.0 - valueAt(near_row_, point);
  const auto ray =
      perspective_ ? clipped(glm::dvec3(0.0), point / w) : clipped(point - t * depth_, depth_);
  if (!ray || !(ray->t_min < t && t < ray->t_max)) return std::nullopt;
  return Aimed{*ray, t};
}

std::optional<glm::dvec2> ViewRays::imageOf(const glm::dvec3& point) const {
  const double w = valueAt(w_row_, point);
  if (!(w > 0.0)) return std::nullopt;
  return glm::dvec2(valueAt(x_row_, point), valueAt(y_row_, point)) / w;
}

bool ViewRays::outside(const glm::dvec3& centre, const std::array<glm::dvec3, 3>& axes) const {
  return std::any_of(planes_.begin(), planes_.end(), [&](const glm::dvec4& plane) {
    const glm::dvec3 normal(plane);
    double reach = 0.0;
    for (const glm::dvec3& axis : axes) reach += std::abs(glm::dot(normal, axis));
    const double middle = glm::dot(normal, centre);
    const double margin =
        kSideMargin * (glm::dot(glm::abs(normal), glm::abs(centre)) + std::abs(plane.w) + reach);
    return middle + plane.w + reach < -margin;
  });
}

}  // namespace culld::oracle
