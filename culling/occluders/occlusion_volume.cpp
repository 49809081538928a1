#include "culling/occluders/occlusion_volume.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>

#include "culling/core/piece_contour.h"
#include "culling/core/sum_abs.h"
#include "culling/raster/object_rows.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {
namespace {

constexpr double kUlp = 0x1p-53;
constexpr double kUp = 1.0 + 1e-9;
constexpr double kTiny = 1e-280;    ///< products below it could lose bits without a relative bound
constexpr double kTie = 0x1p-38;    ///< of the distance: what is no farther behind is not hidden
constexpr double kFarthest = 1e90;  ///< beyond it, products could overflow
constexpr std::size_t kMostPlanes = 64;

double largestOf(const glm::dvec3& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// Mesh space to relative coordinates. Every result is known to `error` in each component, and its
/// size is at most `reach` (docs/error-model/occlusion-volumes.md §3).
struct RelativeMap {
  RelativeMap(const std::array<double, 12>& m, const glm::dvec3& origin, const glm::dvec3& largest)
      : rows(m), offset(glm::dvec3(m[3], m[7], m[11]) - origin) {
    for (std::size_t i = 0; i < 3; ++i) {
      const double terms = std::abs(m[4 * i]) * largest.x + std::abs(m[4 * i + 1]) * largest.y +
                           std::abs(m[4 * i + 2]) * largest.z +
                           std::abs(offset[static_cast<int>(i)]);
      reach = std::max(reach, kUp * terms);
    }
    error = 16.0 * kUlp * reach;
  }
  glm::dvec3 operator()(const glm::dvec3& p) const {
    return {rows[0] * p.x + rows[1] * p.y + rows[2] * p.z + offset.x,
            rows[4] * p.x + rows[5] * p.y + rows[6] * p.z + offset.y,
            rows[8] * p.x + rows[9] * p.y + rows[10] * p.z + offset.z};
  }

  const std::array<double, 12>& rows;
  glm::dvec3 offset;
  double reach = 0.0, error = 0.0;
};

/// How far the eye surely is from the box.
double distanceOf(const SeenBox& box) {
  const glm::dvec3 zero(0.0);
  const double distance = glm::length(glm::max(glm::max(box.low, -box.high), zero));
  return distance - 8.0 * kUlp * box.reach;
}

/// No pose's clip planes cut the box: for parallel rays.
bool betweenTheCuts(const SeenBox& box, const VolumeEye& eye) {
  return std::all_of(std::begin(eye.cut_row), std::end(eye.cut_row), [&](const glm::dvec4& row) {
    const glm::dvec3 n(row);
    const glm::dvec3 corner(n.x > 0 ? box.low.x : box.high.x, n.y > 0 ? box.low.y : box.high.y,
                            n.z > 0 ? box.low.z : box.high.z);
    const double error = 16.0 * kUlp * (sumAbs(n) * box.reach + std::abs(row.w));
    return glm::dot(n, corner) + row.w > error + eye.cut_radius_m * kUp * glm::length(n);
  });
}

}  // namespace

/// One occluder on its way to a volume.
class VolumeBuilder {
 public:
  VolumeBuilder(const VolumeOccluder& occluder, const std::array<double, 12>& world_from_mesh,
                const VolumeEye& eye, OcclusionVolume& out)
      : shape_(occluder.shape),
        eye_(eye),
        sign_(handedness(world_from_mesh)),
        map_(world_from_mesh, eye.origin_world,
             glm::max(glm::abs(occluder.box_mesh.min), glm::abs(occluder.box_mesh.max))),
        out_(out) {
    const Box world = boundsOf(world_from_mesh, occluder.box_mesh);
    out_.box_ = seenBox({}, world.min - eye.origin_world, world.max - eye.origin_world);
    clear_ = eye.perspective ? distanceOf(out_.box_) > eye.near_m + eye.radius_m
                             : betweenTheCuts(out_.box_, eye);
    usable_ = sign_ != 0.0 && shape_.vertices.size() <= kMostPieceVertices &&
              shape_.faces.size() <= kMostPieceFaces && map_.reach < kFarthest &&
              (clear_ || (eye.perspective && !occluder.solid));
  }

  bool run(const VolumeSettings& settings) {
    out_.planes_.clear();
    if (!usable_) return false;
    for (std::size_t v = 0; v < shape_.vertices.size(); ++v)
      points_[v] = map_(glm::dvec3(shape_.vertices[v]));
    const glm::dvec3 facing = addFacing(!settings.collapse);
    if (front_ == 0 || !addContour()) return false;
    if (settings.collapse && !addCollapsed(facing)) return false;
    return out_.planes_.size() <= kMostPlanes;
  }

 private:
  /// Finds the faces that surely turn to the eye, wherever it moves. Their normals, summed, point
  /// away from it.
  glm::dvec3 addFacing(bool as_planes) {
    glm::dvec3 sum(0.0);
    for (std::size_t f = 0; f < shape_.faces.size(); ++f) {
      VolumePlane plane;
      if (!facingPlane(shape_.faces[f], plane)) continue;
      front_ |= std::uint64_t{1} << f;
      sum += plane.normal;
      if (as_planes) out_.planes_.push_back(plane);
    }
    return sum;
  }

  /// False: it does not surely turn to the eye, or a clip plane could cut it.
  bool facingPlane(const PieceFace& face, VolumePlane& plane) const {
    const glm::dvec3 &p = points_[face.corner[0]], &q = points_[face.corner[1]],
                     &r = points_[face.corner[2]];
    const glm::dvec3 a = q - p, b = r - p;
    const double largest = std::max(largestOf(a), largestOf(b)), e = map_.error;
    const glm::dvec3 n = -sign_ * glm::cross(a, b);
    const double n_error = 10.0 * e * (largest + e) + kTiny;
    plane.normal = n;
    plane.offset = glm::dot(n, p);
    plane.length = kUp * (glm::length(n) + 2.0 * n_error);
    plane.slack = 4.0 * n_error * map_.reach + sumAbs(n) * (2.0 * e + kTie * map_.reach) + kTiny;
    plane.slack_per_m = 4.0 * n_error + 16.0 * kUlp * sumAbs(n);
    if (eye_.perspective) {
      const double away = eye_.radius_m + (clear_ ? 0.0 : eye_.near_m);
      return plane.offset - plane.slack > away * plane.length;
    }
    const double error = 4.0 * n_error + 2.0 * sumAbs(n) * (eye_.along_error + 4.0 * kUlp);
    return glm::dot(n, eye_.along) > error;
  }

  /// False: there is none.
  bool addContour() {
    glm::dvec3 area(0.0);
    const std::size_t before = out_.planes_.size();
    for (const PieceEdge& edge : shape_.edges) {
      const EdgeRole role = roleOf(edge, front_);
      if (role == EdgeRole::kAway) continue;
      front_vertices_ |= std::uint64_t{1} << edge.from | std::uint64_t{1} << edge.to;
      if (role == EdgeRole::kInner) continue;
      const bool along = (role == EdgeRole::kForward) == (sign_ > 0.0);
      const glm::dvec3 &p = points_[along ? edge.from : edge.to],
                       &q = points_[along ? edge.to : edge.from];
      addEdge(p, q);
      area +=
          eye_.perspective ? glm::cross(glm::normalize(p), glm::normalize(q)) : glm::cross(p, q);
    }
    const double size = eye_.perspective ? glm::length(area) : std::abs(glm::dot(area, eye_.along));
    out_.share_ = 0.5 * size / eye_.image;
    return out_.planes_.size() > before;
  }

  void addEdge(const glm::dvec3& p, const glm::dvec3& q) {
    VolumePlane& plane = out_.planes_.emplace_back();
    const double e = map_.error, reach = map_.reach;
    double n_error = 5.0 * e * reach + kTiny;
    if (eye_.perspective) {
      plane.normal = glm::cross(q, p);
    } else {
      plane.normal = glm::cross(q - p, eye_.along);
      plane.offset = glm::dot(plane.normal, p);
      n_error = 6.0 * e + 5.0 * reach * eye_.along_error + kTiny;
    }
    plane.length = kUp * (glm::length(plane.normal) + 2.0 * n_error);
    plane.slack_per_m = 4.0 * n_error + 16.0 * kUlp * sumAbs(plane.normal);
    plane.slack =
        eye_.perspective ? kTiny : 4.0 * n_error * reach + 2.0 * sumAbs(plane.normal) * e + kTiny;
    plane.edge = q - p;
    plane.start = p;
    plane.edge_length = kUp * (glm::length(plane.edge) + 8.0 * e);
    plane.edge_error = e;
  }

  /// One plane beyond all vertices that turn to the eye, for all facing ones.
  bool addCollapsed(const glm::dvec3& normal) {
    VolumePlane plane;
    plane.normal = normal;
    plane.length = kUp * glm::length(normal) + kTiny;
    const double size = sumAbs(normal);
    plane.offset = eye_.radius_m * plane.length;
    if (!eye_.perspective) {
      plane.offset = -std::numeric_limits<double>::infinity();
      const double error = 2.0 * size * (eye_.along_error + 4.0 * kUlp) + kTiny;
      if (!(glm::dot(normal, eye_.along) > error)) return false;
    }
    for (std::size_t v = 0; v < shape_.vertices.size(); ++v) {
      if ((front_vertices_ >> v & 1U) != 0)
        plane.offset = std::max(plane.offset, glm::dot(normal, points_[v]));
    }
    plane.slack = size * (2.0 * map_.error + kTie * map_.reach) + kTiny;
    plane.slack_per_m = 16.0 * kUlp * size;
    out_.planes_.push_back(plane);
    return true;
  }

  const ConvexPiece& shape_;
  const VolumeEye& eye_;
  double sign_;
  RelativeMap map_;
  OcclusionVolume& out_;
  bool clear_ = false;  ///< no clip plane can cut anything of the occluder
  bool usable_ = false;
  std::array<glm::dvec3, kMostPieceVertices> points_;
  std::uint64_t front_ = 0;           ///< faces
  std::uint64_t front_vertices_ = 0;  ///< of those
};

bool OcclusionVolume::build(const VolumeOccluder& occluder,
                            const std::array<double, 12>& world_from_mesh, const VolumeEye& eye,
                            const VolumeSettings& settings) {
  radius_m_ = eye.radius_m;
  sphere_first_ = settings.sphere_first;
  return VolumeBuilder(occluder, world_from_mesh, eye, *this).run(settings);
}

namespace {

/// By how much the plane's value may fall as the eye moves, at a point known to 2 units of `reach`.
double sway(const VolumePlane& plane, const glm::dvec3& x, double reach, double radius_m) {
  if (radius_m == 0.0 || plane.edge_length == 0.0) return 0.0;
  const glm::dvec3 away = x - plane.start;
  const double e = plane.edge_error + 4.0 * kUlp * reach;
  const double error = 8.0 * e * (sumAbs(away) + sumAbs(plane.edge) + e);
  return radius_m * kUp * (glm::length(glm::cross(plane.edge, away)) + error);
}

double slackOf(const VolumePlane& plane, double reach) {
  return plane.slack + plane.slack_per_m * reach;
}

glm::dvec3 corner(const SeenBox& box, std::uint32_t which) {
  return {(which & 1U) != 0 ? box.high.x : box.low.x, (which & 2U) != 0 ? box.high.y : box.low.y,
          (which & 4U) != 0 ? box.high.z : box.low.z};
}

/// The corner where the plane's value is least.
std::uint32_t leastCorner(const glm::dvec3& normal) {
  return (normal.x < 0 ? 1U : 0U) | (normal.y < 0 ? 2U : 0U) | (normal.z < 0 ? 4U : 0U);
}

}  // namespace

VolumeVerdict OcclusionVolume::test(const SeenBox& box, std::uint64_t& planes) const noexcept {
  if (!(box.reach < kFarthest)) return VolumeVerdict::kPartly;
  if (sphere_first_) {
    bool centre_inside = true;
    const VolumeVerdict verdict = testSphere(box, centre_inside, planes);
    if (verdict != VolumeVerdict::kPartly || !centre_inside) return verdict;
    return hidesCorners(box, planes) ? VolumeVerdict::kHidden : VolumeVerdict::kMostly;
  }
  for (const VolumePlane& plane : planes_) {
    ++planes;
    const glm::dvec3 best = corner(box, leastCorner(plane.normal) ^ 7U);
    if (glm::dot(plane.normal, best) < plane.offset) return VolumeVerdict::kOutside;
  }
  return hidesCorners(box, planes) ? VolumeVerdict::kHidden : VolumeVerdict::kMostly;
}

VolumeVerdict OcclusionVolume::testSphere(const SeenBox& box, bool& centre_inside,
                                          std::uint64_t& planes) const noexcept {
  const glm::dvec3 centre = 0.5 * box.low + 0.5 * box.high;
  const double radius = kUp * 0.5 * glm::length(box.high - box.low) + 8.0 * kUlp * box.reach;
  bool all_inside = true;
  for (const VolumePlane& plane : planes_) {
    ++planes;
    const double value = glm::dot(plane.normal, centre) - plane.offset;
    if (value < -plane.length * radius) return VolumeVerdict::kOutside;
    const double lost = sway(plane, centre, box.reach, radius_m_) + slackOf(plane, box.reach);
    const double spread = kUp * radius * (plane.length + radius_m_ * plane.edge_length);
    if (!(value > lost)) centre_inside = false;
    if (!(value - spread > lost)) all_inside = false;
  }
  return all_inside ? VolumeVerdict::kHidden : VolumeVerdict::kPartly;
}

bool OcclusionVolume::hidesCorners(const SeenBox& box, std::uint64_t& planes) const noexcept {
  for (const VolumePlane& plane : planes_) {
    const double slack = slackOf(plane, box.reach);
    const std::uint32_t least = leastCorner(plane.normal);
    // An eye that stands still needs the worst corner only; sway differs from corner to corner.
    const bool still = radius_m_ == 0.0 || plane.edge_length == 0.0;
    for (std::uint32_t i = 0; i < (still ? 1U : 8U); ++i) {
      ++planes;
      const glm::dvec3 x = corner(box, i ^ least);
      const double value = glm::dot(plane.normal, x) - plane.offset;
      if (!(value - sway(plane, x, box.reach, radius_m_) > slack)) return false;
    }
  }
  return true;
}

bool OcclusionVolume::hidesPoints(std::span<const glm::dvec3> points, double reach,
                                  std::uint64_t& planes) const noexcept {
  if (!(reach < kFarthest)) return false;
  for (const VolumePlane& plane : planes_) {
    const double slack = slackOf(plane, reach);
    for (const glm::dvec3& x : points) {
      ++planes;
      const double value = glm::dot(plane.normal, x) - plane.offset;
      if (!(value - sway(plane, x, reach, radius_m_) > slack)) return false;
    }
  }
  return true;
}

SeenBox seenBox(const glm::dvec3& origin, const glm::dvec3& low, const glm::dvec3& high) noexcept {
  const double reach = largestOf(origin) + std::max(largestOf(low), largestOf(high));
  return {origin + low, origin + high, kUp * reach};
}

double seenCorners(const Box& box_mesh, const std::array<double, 12>& world_from_mesh,
                   const VolumeEye& eye, std::array<glm::dvec3, 8>& corners) noexcept {
  const RelativeMap map(world_from_mesh, eye.origin_world,
                        glm::max(glm::abs(box_mesh.min), glm::abs(box_mesh.max)));
  for (std::uint32_t i = 0; i < 8; ++i)
    corners[i] = map(corner({box_mesh.min, box_mesh.max, 0.0}, i));
  // Its bounds are padded for the rounding of world coordinates; these count as if they were.
  return 8.0 * map.reach + largestOf(eye.origin_world);
}

}  // namespace culld
