#include "culling/planner/overhang.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <vector>

#include "culling/planner/sampled_objects.h"

namespace culld {
namespace {

constexpr std::size_t kObjects = 2048, kTriangles = 32, kSide = 32;

struct SampledTriangle {
  glm::dvec3 middle;
  double shadow;  ///< its area seen along y, times what it stands for; below 0: it faces down
};

double handednessOf(const std::array<double, 12>& m) {
  const glm::dvec3 x(m[0], m[4], m[8]), y(m[1], m[5], m[9]), z(m[2], m[6], m[10]);
  return glm::dot(glm::cross(x, y), z) < 0.0 ? -1.0 : 1.0;
}

void sampleObject(const SceneSnapshot& scene, const Instance& instance,
                  std::vector<SampledTriangle>& out) {
  const Mesh& mesh = scene.mesh(instance.mesh);
  const double side = handednessOf(instance.world_from_mesh);
  for (const Surface& surface : mesh.surfaces) {
    if (!surface.blocks) continue;
    const std::size_t share = 1 + kTriangles * surface.triangle_count / mesh.blocking_triangles;
    const std::size_t samples = std::min<std::size_t>(share, surface.triangle_count);
    const bool all = samples == surface.triangle_count;
    const double stands_for =
        static_cast<double>(surface.triangle_count) / static_cast<double>(samples);
    for (std::size_t k = 0; k < samples; ++k) {
      // By the golden ratio: even steps may meet the tops of all houses and no bottom.
      const double place = static_cast<double>(k) * 0.6180339887498949;
      const double fraction = place - std::floor(place);
      const auto hop = static_cast<std::size_t>(fraction * surface.triangle_count);
      const auto& corner = mesh.triangles[surface.first_triangle + (all ? k : hop)];
      std::array<glm::dvec3, 3> p;
      for (std::size_t i = 0; i < 3; ++i) {
        p[i] = toWorld(instance.world_from_mesh, mesh.positions[corner[i]]);
      }
      const double up = glm::cross(p[1] - p[0], p[2] - p[0]).y * side;
      const glm::dvec3 middle = p[0] / 3.0 + p[1] / 3.0 + p[2] / 3.0;
      const double finite = up + middle.x + middle.y + middle.z;
      if (std::isfinite(finite)) out.push_back({middle, up * stands_for});
    }
  }
}

/// The lowest surface around each place.
class Ground {
 public:
  explicit Ground(const std::vector<SampledTriangle>& triangles) {
    for (const SampledTriangle& t : triangles) box_.grow(t.middle);
    lowest_.fill(HUGE_VAL);
    for (const SampledTriangle& t : triangles) {
      double& lowest = lowest_[cellOf(t.middle)];
      lowest = std::min(lowest, t.middle.y);
    }
  }
  double under(const glm::dvec3& p) const { return lowest_[cellOf(p)]; }

 private:
  std::size_t cellOf(const glm::dvec3& p) const {
    const auto along = [&](int axis) {
      // Halved: the difference of two finite numbers may be infinite.
      const double size = std::max(0.5 * box_.max[axis] - 0.5 * box_.min[axis], 1e-30);
      const double at = (0.5 * p[axis] - 0.5 * box_.min[axis]) / size * kSide;
      return static_cast<std::size_t>(std::clamp(at, 0.0, kSide - 1.0));
    };
    return along(2) * kSide + along(0);
  }
  Box box_;
  std::array<double, kSide * kSide> lowest_;
};

}  // namespace

double overhangOf(const SceneSnapshot& scene) {
  std::vector<SampledTriangle> triangles;
  std::vector<double> heights;
  for (const ObjectId id : sampledObjects(scene, kObjects)) {
    const Instance& instance = scene.instance(id);
    heights.push_back(instance.bounds_world.max.y - instance.bounds_world.min.y);
    sampleObject(scene, instance, triangles);
  }
  if (triangles.empty()) return 0.0;
  const auto middle = heights.begin() + static_cast<std::ptrdiff_t>(heights.size() / 2);
  std::nth_element(heights.begin(), middle, heights.end());
  const double well_above = *middle / 4.0;
  const Ground ground(triangles);
  double all = 0.0, hanging = 0.0;
  for (const SampledTriangle& t : triangles) {
    all += std::abs(t.shadow);
    if (t.shadow < 0.0 && t.middle.y > ground.under(t.middle) + well_above) hanging -= t.shadow;
  }
  return all > 0.0 ? hanging / all : 0.0;
}

}  // namespace culld
