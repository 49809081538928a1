#include "culling/spatial/triangle_voxels.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace culld {
namespace {

/// Of the longest product of the axes' terms (docs/error-model/solids.md §2).
constexpr double kEdgeSlack = 0x1p-46, kPlaneSlack = 0x1p-42;

double largestOf(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// Beside the box in one of its own directions. Exact: nothing but comparisons of what was given.
bool besideTheFaces(const WorldTriangle& t, const Box& box) {
  for (int axis = 0; axis < 3; ++axis) {
    const double low = std::min({t[0][axis], t[1][axis], t[2][axis]});
    const double high = std::max({t[0][axis], t[1][axis], t[2][axis]});
    if (high <= box.min[axis] || low >= box.max[axis]) return true;
  }
  return false;
}

}  // namespace

bool clearOfInside(const WorldTriangle& triangle, const Box& box) noexcept {
  if (besideTheFaces(triangle, box)) return true;
  const glm::dvec3 centre = 0.5 * box.min + 0.5 * box.max;
  const glm::dvec3 half = (1.0 + 0x1p-50) * glm::max(box.max - centre, centre - box.min);
  const std::array<glm::dvec3, 3> v{triangle[0] - centre, triangle[1] - centre,
                                    triangle[2] - centre};
  const double reach =
      std::max({largestOf(v[0]), largestOf(v[1]), largestOf(v[2]), largestOf(half)});
  const glm::dvec3 normal = glm::cross(v[1] - v[0], v[2] - v[0]);
  const double plane_slack = kPlaneSlack * reach * reach * reach + 1e-280;
  if (std::abs(glm::dot(normal, v[0])) > glm::dot(glm::abs(normal), half) + plane_slack) {
    return reach < 1e90;
  }
  const double edge_slack = kEdgeSlack * reach * reach + 1e-280;
  for (int e = 0; e < 3; ++e) {
    const auto i = static_cast<std::size_t>(e);
    const glm::dvec3 edge = v[(i + 1) % 3] - v[i];
    for (int a = 0; a < 3; ++a) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      // The edge and the triangle's third corner, seen along axis a, across the edge.
      const double at_edge = edge[b] * v[i][c] - edge[c] * v[i][b];
      const glm::dvec3& third = v[(i + 2) % 3];
      const double at_third = edge[b] * third[c] - edge[c] * third[b];
      const double radius = std::abs(edge[b]) * half[c] + std::abs(edge[c]) * half[b] + edge_slack;
      if (std::min(at_edge, at_third) > radius || std::max(at_edge, at_third) < -radius) {
        return reach < 1e90;
      }
    }
  }
  return false;
}

std::uint64_t markVoxels(const WorldTriangle& triangle, const VoxelGrid& grid,
                         const VoxelRange& range, VoxelBits& bits) {
  struct Halver {
    const WorldTriangle& triangle;
    const VoxelGrid& grid;
    const Voxel& origin;
    VoxelBits& bits;
    std::uint64_t tested = 0;

    void mark(const VoxelRange& r) {
      ++tested;
      if (clearOfInside(triangle, grid.boundsOf(r))) return;
      std::size_t longest = 0;
      for (std::size_t a = 1; a < 3; ++a) {
        if (r.last[a] - r.first[a] > r.last[longest] - r.first[longest]) longest = a;
      }
      if (r.last[longest] - r.first[longest] == 1) {
        bits.set({r.first[0] - origin[0], r.first[1] - origin[1], r.first[2] - origin[2]});
        return;
      }
      VoxelRange lower = r, upper = r;
      lower.last[longest] = upper.first[longest] = (r.first[longest] + r.last[longest]) / 2;
      mark(lower);
      mark(upper);
    }
  };
  Box around;
  for (const glm::dvec3& corner : triangle) around.grow(corner);
  VoxelRange reached = grid.touching(around);
  for (std::size_t a = 0; a < 3; ++a) {
    reached.first[a] = std::max(reached.first[a], range.first[a]);
    reached.last[a] = std::min(reached.last[a], range.last[a]);
  }
  if (reached.empty()) return 0;
  Halver halver{triangle, grid, range.first, bits};
  halver.mark(reached);
  return halver.tested;
}

}  // namespace culld
