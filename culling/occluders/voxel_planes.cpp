#include "culling/occluders/voxel_planes.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <utility>

namespace culld {
namespace {

constexpr std::size_t kMostTriangles = 1U << 22U;  ///< looked at for planes

/// Faces that lie in one plane across an axis.
struct Wall {
  double at, area;
};

using Walls = std::vector<Wall>;

void addWall(const WorldTriangle& t, double snap, std::array<Walls, 3>& walls) {
  for (int axis = 0; axis < 3; ++axis) {
    const double low = std::min({t[0][axis], t[1][axis], t[2][axis]});
    const double high = std::max({t[0][axis], t[1][axis], t[2][axis]});
    if (high - low > snap) continue;
    const double area = 0.5 * glm::length(glm::cross(t[1] - t[0], t[2] - t[0]));
    walls[static_cast<std::size_t>(axis)].push_back({low, area});
  }
}

std::array<Walls, 3> wallsOf(const SolidParts& parts, double snap) {
  std::array<Walls, 3> walls;
  std::vector<WorldTriangle> triangles;
  std::size_t looked_at = 0;
  for (const SolidPart& part : parts.parts()) {
    looked_at += part.part->triangles.size();
    if (looked_at > kMostTriangles) break;
    triangles.clear();
    parts.appendTriangles(part, triangles);
    for (const WorldTriangle& t : triangles) addWall(t, snap, walls);
  }
  return walls;
}

/// One wall for all that are closer to their neighbours than `snap`.
Walls merged(Walls walls, double snap) {
  std::sort(walls.begin(), walls.end(), [](const Wall& a, const Wall& b) {
    return std::pair(a.at, a.area) < std::pair(b.at, b.area);
  });
  Walls out;
  for (const Wall& wall : walls) {
    if (!out.empty() && wall.at - out.back().at <= snap) {
      out.back().area += wall.area;
    } else {
      out.push_back(wall);
    }
  }
  return out;
}

/// The places of the largest walls strictly inside, and both ends.
std::vector<double> wallPlanes(Walls walls, double low, double high, double snap,
                               std::size_t most) {
  std::erase_if(walls, [&](const Wall& w) { return !(w.at > low + snap && w.at < high - snap); });
  std::stable_sort(walls.begin(), walls.end(),
                   [](const Wall& a, const Wall& b) { return a.area > b.area; });
  if (walls.size() > most) walls.resize(most);
  std::vector<double> planes{low, high};
  for (const Wall& wall : walls) planes.push_back(wall.at);
  std::sort(planes.begin(), planes.end());
  return planes;
}

/// Further planes wherever two are farther apart than `step`.
std::vector<double> refined(const std::vector<double>& planes, double step) {
  std::vector<double> out;
  for (std::size_t i = 0; i + 1 < planes.size(); ++i) {
    const double width = planes[i + 1] - planes[i];
    const double parts = std::max(1.0, std::ceil(width / step - 1e-9));
    for (double k = 0.0; k < parts; k += 1.0) out.push_back(planes[i] + width * (k / parts));
  }
  out.push_back(planes.back());
  return out;
}

std::uint64_t mostVoxels(const SolidParts& parts, const VoxelLimits& limits) {
  std::uint64_t triangles = 0;
  for (const SolidPart& part : parts.parts()) triangles += part.part->triangles.size();
  return std::min(limits.most_voxels,
                  std::max(limits.few_voxels, limits.voxels_per_triangle * triangles));
}

}  // namespace

double voxelSnap(const Box& world) noexcept {
  const glm::dvec3 most = glm::max(glm::abs(world.min), glm::abs(world.max));
  return 0x1p-46 * std::max({most.x, most.y, most.z});
}

VoxelGrid voxelGridFor(const SolidParts& parts, const Box& world, const VoxelLimits& limits) {
  const double snap = voxelSnap(world);
  std::array<Walls, 3> walls = wallsOf(parts, snap);
  std::array<std::vector<double>, 3> planes;
  glm::dvec3 low = world.min, high = world.max;
  const glm::dvec3 extent = high - low;
  const double thinnest = 1e-3 * std::max({extent.x, extent.y, extent.z}) + 1e-300;
  double longest = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    // Flat scenes get a voxel of some thickness.
    const double room = 1e-3 * std::max(extent[axis], thinnest) + 16.0 * snap;
    low[axis] -= room;
    high[axis] += room;
    longest = std::max(longest, high[axis] - low[axis]);
    const auto a = static_cast<std::size_t>(axis);
    planes[a] = wallPlanes(merged(std::move(walls[a]), snap), low[axis], high[axis], 4.0 * snap,
                           limits.most_wall_planes);
  }
  const std::uint64_t most = mostVoxels(parts, limits);
  for (double step = longest / limits.even_voxels;; step *= 1.25) {
    const VoxelGrid grid(
        {refined(planes[0], step), refined(planes[1], step), refined(planes[2], step)});
    if (grid.all().size() <= most || step > longest) return grid;
  }
}

}  // namespace culld
