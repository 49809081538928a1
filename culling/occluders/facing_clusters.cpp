#include "culling/occluders/facing_clusters.h"

#include <cmath>
#include <glm/geometric.hpp>

#include "culling/core/sum_abs.h"

namespace culld {
namespace {

constexpr std::size_t kMostOpen = 64;  ///< clusters are halved: they are no more than 32 deep

}  // namespace

FacingRegion FacingClusters::regionOf(const Cluster& c, const MeshEye& eye) noexcept {
  if (!c.certain) return FacingRegion::kMixed;
  // The largest n . v over the normals n of a cone is |v| cos(angle(v, axis) - the cone's angle).
  const glm::dvec3 v = eye.parallel ? eye.at : eye.at - c.middle;
  const double along = glm::dot(c.axis, v);
  const double aside = glm::length(v - along * c.axis);
  const double below = eye.parallel ? 0.0 : c.below, above = eye.parallel ? 0.0 : c.above;
  const double margin = eye.radius + 1e-13 * sumAbs(v) + 1e-300;
  if (c.cosine * along + c.sine * aside + below + margin < 0.0) return FacingRegion::kBack;
  const bool front = c.cosine * along - c.sine * aside > above;
  return front ? FacingRegion::kFront : FacingRegion::kMixed;
}

/// Calls take(cluster, region) in order for clusters that are decided or not divided, until it
/// returns false.
template <typename Take>
void FacingClusters::walk(std::uint32_t root, const MeshEye& eye, bool hierarchy,
                          std::uint64_t& regions, const Take& take) const {
  std::array<std::uint32_t, kMostOpen> stack{};
  std::size_t open = 0;
  stack[open++] = root;
  while (open > 0) {
    const std::uint32_t index = stack[--open];
    const Cluster& cluster = clusters_[index];
    const bool leaf = cluster.right == 0;
    FacingRegion region = FacingRegion::kMixed;
    if (leaf || hierarchy) {
      ++regions;
      region = regionOf(cluster, eye);
    }
    if (region == FacingRegion::kMixed && !leaf) {
      stack[open++] = cluster.right;
      stack[open++] = index + 1;
    } else if (!take(cluster, region)) {
      return;
    }
  }
}

bool FacingClusters::turnedAway(const MeshEye& eye, bool hierarchy, std::uint64_t most_regions,
                                std::uint64_t& regions) const {
  const std::uint64_t end = regions + most_regions;
  bool away = one_sided_;
  for (std::size_t i = 0; i < roots_.size() && away; ++i) {
    walk(roots_[i], eye, hierarchy, regions, [&](const Cluster&, FacingRegion region) {
      away = region == FacingRegion::kBack && regions <= end;
      return away;
    });
  }
  return away;
}

std::uint32_t FacingClusters::appendFacing(const Mesh& mesh, const MeshEye& eye, bool hierarchy,
                                           std::vector<SheetSurface>& out,
                                           std::uint64_t& regions) const {
  std::uint32_t triangles = 0;
  for (std::size_t i = 0; i < mesh.surfaces.size(); ++i) {
    const Surface& s = mesh.surfaces[i];
    if (!s.blocks) continue;
    if (roots_[i] == kNoCluster) {
      out.push_back({s.first_triangle, s.triangle_count, s.double_sided});
      triangles += s.triangle_count;
      continue;
    }
    bool goes_on = false;  // the last run ends where the next cluster begins
    walk(roots_[i], eye, hierarchy, regions, [&](const Cluster& cluster, FacingRegion region) {
      const bool facing = region != FacingRegion::kBack;
      if (facing && goes_on) {
        out.back().triangle_count += cluster.count;
      } else if (facing) {
        out.push_back({cluster.first, cluster.count, false});
      }
      triangles += facing ? cluster.count : 0;
      goes_on = facing;
      return true;
    });
  }
  return triangles;
}

std::size_t FacingClusters::bytes() const noexcept {
  return sizeof(FacingClusters) + clusters_.capacity() * sizeof(Cluster) +
         roots_.capacity() * sizeof(std::uint32_t) + triangles_.capacity() * sizeof(triangles_[0]) +
         partners_.capacity() * sizeof(std::uint32_t);
}

}  // namespace culld
