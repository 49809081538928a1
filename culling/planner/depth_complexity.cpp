#include "culling/planner/depth_complexity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

namespace culld {
namespace {

/// In pixels times w, from the upper left; near and far are >= 0 between the clip planes.
struct Corner {
  double x, y, w, near, far;
};

/// From `in` to `beyond`, where `in_at` and `beyond_at` differ in sign, to where they are 0.
Corner cutBetween(const Corner& in, const Corner& beyond, double in_at, double beyond_at) {
  const double t = in_at / (in_at - beyond_at);
  const auto at = [t](double from, double to) { return from + (to - from) * t; };
  return {at(in.x, beyond.x), at(in.y, beyond.y), at(in.w, beyond.w), at(in.near, beyond.near),
          at(in.far, beyond.far)};
}

/// A triangle cut at three planes has at most six corners.
struct Polygon {
  std::array<Corner, 6> corner;
  std::size_t corners = 0;

  /// Cuts off what is on the negative side. An edge is cut at the same place from both its ends.
  void cutBy(double Corner::*side, double least) {
    Polygon out;
    for (std::size_t i = 0; i < corners; ++i) {
      const Corner &a = corner[i], &b = corner[(i + 1) % corners];
      const double at_a = a.*side - least, at_b = b.*side - least;
      if (at_a >= 0.0) out.corner[out.corners++] = a;
      if ((at_a >= 0.0) == (at_b >= 0.0)) continue;
      out.corner[out.corners++] =
          at_a >= 0.0 ? cutBetween(a, b, at_a, at_b) : cutBetween(b, a, at_b, at_a);
    }
    *this = out;
  }
};

/// Counts polygons into the pixels whose centres they hold.
class Counter {
 public:
  Counter(const Camera& camera, DepthComplexity& to)
      : camera_(camera),
        to_(to),
        width_(static_cast<double>(to.width_px)),
        height_(static_cast<double>(to.height_px)) {}

  Corner project(const glm::dvec3& p_world) const {
    const glm::dvec4 q(p_world - camera_.origin_world, 1.0);
    const double w = glm::dot(camera_.w_row, q);
    return {0.5 * (w + glm::dot(camera_.x_row, q)) * width_,
            0.5 * (w - glm::dot(camera_.y_row, q)) * height_, w, glm::dot(camera_.near_cut_row, q),
            glm::dot(camera_.far_cut_row, q)};
  }

  bool mayBeSeen(const Box& box) const {
    std::array<bool, 6> outside;
    outside.fill(true);
    for (unsigned i = 0; i < 8; ++i) {
      const Corner p =
          project({(i & 1U) != 0 ? box.max.x : box.min.x, (i & 2U) != 0 ? box.max.y : box.min.y,
                   (i & 4U) != 0 ? box.max.z : box.min.z});
      const std::array<double, 6> inside{p.x,  p.w * width_ - p.x, p.y, p.w * height_ - p.y, p.near,
                                         p.far};
      for (std::size_t s = 0; s < 6; ++s) outside[s] = outside[s] && inside[s] < 0.0;
    }
    return std::none_of(outside.begin(), outside.end(), [](bool out) { return out; });
  }

  void count(const std::array<glm::dvec3, 3>& corner) {
    Polygon polygon;
    for (const glm::dvec3& p : corner) polygon.corner[polygon.corners++] = project(p);
    polygon.cutBy(&Corner::near, 0.0);
    polygon.cutBy(&Corner::far, 0.0);
    polygon.cutBy(&Corner::w, kLeastW);
    if (polygon.corners < 3) return;
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (std::size_t i = 0; i < polygon.corners; ++i) {
      Corner& p = polygon.corner[i];
      p.x /= p.w;
      p.y /= p.w;
      low = std::min(low, p.y);
      high = std::max(high, p.y);
    }
    const double first = std::max(std::ceil(low - 0.5), 0.0);
    const double end = std::min(std::ceil(high - 0.5), height_);
    for (double row = first; row < end; row += 1.0) countRow(polygon, row);
  }

 private:
  static constexpr double kLeastW = 1e-30;  ///< before the eye

  /// Of a convex polygon: between its two crossings with the line through the row's centres.
  void countRow(const Polygon& polygon, double row) {
    const double middle = row + 0.5;
    double left = HUGE_VAL, right = -HUGE_VAL;
    for (std::size_t i = 0; i < polygon.corners; ++i) {
      const Corner &a = polygon.corner[i], &b = polygon.corner[(i + 1) % polygon.corners];
      if ((a.y <= middle) == (b.y <= middle)) continue;
      const Corner &above = a.y < b.y ? a : b, &below = a.y < b.y ? b : a;
      const double x = above.x + (below.x - above.x) * ((middle - above.y) / (below.y - above.y));
      left = std::min(left, x);
      right = std::max(right, x);
    }
    const double first = std::max(std::ceil(left - 0.5), 0.0);
    const double end = std::min(std::ceil(right - 0.5), width_);
    if (!(first < end)) return;
    const auto at = to_.surfaces.begin() + static_cast<std::ptrdiff_t>(row * width_);
    std::for_each(at + static_cast<std::ptrdiff_t>(first), at + static_cast<std::ptrdiff_t>(end),
                  [](std::uint32_t& surfaces) { ++surfaces; });
  }

  const Camera& camera_;
  DepthComplexity& to_;
  double width_, height_;
};

}  // namespace

double DepthComplexity::mean() const noexcept {
  const double all = std::accumulate(surfaces.begin(), surfaces.end(), 0.0);
  return surfaces.empty() ? 0.0 : all / static_cast<double>(surfaces.size());
}

std::uint32_t DepthComplexity::most() const noexcept {
  return surfaces.empty() ? 0 : *std::max_element(surfaces.begin(), surfaces.end());
}

std::uint32_t DepthComplexity::percentile(double share) const {
  const double wanted = share * static_cast<double>(surfaces.size());
  double pixels = 0.0;
  std::uint32_t number = 0;
  for (const std::uint64_t of_number : histogram()) {
    pixels += static_cast<double>(of_number);
    if (pixels >= wanted) break;
    ++number;
  }
  return std::min(number, most());
}

std::vector<std::uint64_t> DepthComplexity::histogram() const {
  std::vector<std::uint64_t> pixels(surfaces.empty() ? 0 : std::size_t{most()} + 1, 0);
  for (const std::uint32_t number : surfaces) ++pixels[number];
  return pixels;
}

DepthComplexity depthComplexity(const SceneSnapshot& scene, const Camera& camera,
                                std::uint32_t width_px, std::uint32_t height_px) {
  DepthComplexity out{width_px, height_px, {}};
  out.surfaces.assign(std::size_t{width_px} * height_px, 0);
  Counter counter(camera, out);
  for (std::size_t i = 0; i < scene.objectCount(); ++i) {
    const Instance& instance = scene.instance(static_cast<ObjectId>(i));
    if (!instance.active()) continue;
    if (!instance.always_kept && !counter.mayBeSeen(instance.bounds_world)) continue;
    const Mesh& mesh = scene.mesh(instance.mesh);
    for (const auto& corner : mesh.triangles) {
      std::array<glm::dvec3, 3> p;
      for (std::size_t k = 0; k < 3; ++k) {
        p[k] = toWorld(instance.world_from_mesh, glm::dvec3(mesh.positions[corner[k]]));
      }
      counter.count(p);
    }
  }
  return out;
}

}  // namespace culld
