#include "tests/scenes/city_cameras.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "tests/scenes/city_meshes.h"

namespace culld::scenes {
namespace {

constexpr double kEyeHeight = 1.7;
constexpr double kLookAhead = 9.0;

/// A line through points, walked by length.
class Path {
 public:
  explicit Path(std::vector<glm::dvec3> points) : points_(std::move(points)) {
    for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
      length_ += glm::length(points_[i + 1] - points_[i]);
    }
  }
  double length() const { return length_; }

  /// Past the end it goes straight on.
  glm::dvec3 at(double s) const {
    for (std::size_t i = 0; i + 1 < points_.size(); ++i) {
      const glm::dvec3 leg = points_[i + 1] - points_[i];
      const double l = glm::length(leg);
      if (s <= l || i + 2 == points_.size()) return points_[i] + leg * (s / l);
      s -= l;
    }
    return points_.front();
  }

 private:
  std::vector<glm::dvec3> points_;
  double length_ = 0.0;
};

/// Crossings from one corner of the inner city to the other, turning at most of them.
Path walkThrough(const CityExtent& city) {
  const auto crossing = [&](std::uint32_t i, std::uint32_t j) {
    return glm::dvec3((i - city.columns / 2.0) * kBlockPitch, kEyeHeight,
                      (j - city.rows / 2.0) * kBlockPitch);
  };
  std::uint32_t i = city.columns / 3, j = city.rows / 3;
  std::vector<glm::dvec3> points{crossing(i, j)};
  for (std::uint32_t turn = 0; turn < 6; ++turn) {
    const std::uint32_t blocks = turn % 3 == 1 ? 2 : 1;
    std::uint32_t& along = turn % 2 == 0 ? i : j;
    const std::uint32_t last = turn % 2 == 0 ? city.columns : city.rows;
    const std::uint32_t next = std::min(along + blocks, last);
    if (next == along) continue;
    along = next;
    points.push_back(crossing(i, j));
  }
  return Path(std::move(points));
}

CameraSpec look(const glm::dvec3& eye, const glm::dvec3& target, bool far_away) {
  LookAt pose;
  pose.eye = eye;
  pose.target = target;
  pose.yfov_rad = std::numbers::pi / 3;
  if (!far_away) pose.zfar_m = 5000.0;
  return {pose, {1280, 720}, far_away ? "above" : "street"};
}

}  // namespace

std::vector<CameraSpec> cityCameras(const CityExtent& city, std::uint32_t frames) {
  const Path path = walkThrough(city);
  const std::uint32_t walk = frames - 2 * (frames / 5), climb = frames / 5, above = frames / 5;
  const double top = city.highest_m + 30.0;
  std::vector<CameraSpec> cameras;
  for (std::uint32_t f = 0; f < walk; ++f) {
    const double s = path.length() * f / walk;
    cameras.push_back(look(path.at(s), path.at(s + kLookAhead), false));
  }
  const glm::dvec3 end = path.at(path.length());
  for (std::uint32_t f = 0; f < climb; ++f) {
    const double t = (f + 1.0) / climb, angle = 1.5 * std::numbers::pi * t;
    const glm::dvec3 eye(end.x, kEyeHeight + (top - kEyeHeight) * t * t, end.z);
    const glm::dvec3 ahead(std::cos(angle), -0.5 * t, std::sin(angle));
    cameras.push_back(look(eye, eye + ahead, false));
  }
  const double radius = 0.4 * kBlockPitch * std::max(city.columns, city.rows);
  for (std::uint32_t f = 0; f < above; ++f) {
    const double angle = 2 * std::numbers::pi * f / above;
    const glm::dvec3 eye(radius * std::cos(angle), top, radius * std::sin(angle));
    cameras.push_back(look(eye, glm::dvec3(-0.2 * eye.x, 0.0, -0.2 * eye.z), true));
  }
  return cameras;
}

}  // namespace culld::scenes
