// How clusters are made: each surface's triangles are halved where their places or their normals
// differ most. Every bound that facing rests on is verified here, triangle by triangle, against the
// numbers that are stored (docs/error-model/backface-clusters.md §2).
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>
#include <utility>

#include "culling/core/sum_abs.h"
#include "culling/occluders/facing_clusters.h"

namespace culld {
namespace {

constexpr double kUnit = 0x1p-53;
constexpr double kAngleError = 1e-14;      ///< of what is computed from vectors of length 1
constexpr double kMostSine = 0.9999995;    ///< of a cone: its cosine is above 1e-3, and ...
constexpr double kCosineError = 1e-12;     ///< ... known to this
constexpr double kMostNormalError = 1e-6;  ///< worse, and a triangle's facing is not asked
constexpr double kInf = std::numeric_limits<double>::infinity();

}  // namespace

class ClusterBuilder {
 public:
  ClusterBuilder(const Mesh& mesh, const ClusterRules& rules) : mesh_(mesh), rules_(rules) {}

  FacingClusters run() {
    const auto two_sided = [](const Surface& s) { return s.double_sided; };
    const auto& surfaces = mesh_.surfaces;
    out_.roots_.assign(surfaces.size(), FacingClusters::kNoCluster);
    if (std::all_of(surfaces.begin(), surfaces.end(), two_sided)) return std::move(out_);
    out_.one_sided_ =
        mesh_.points_and_lines == 0 && std::none_of(surfaces.begin(), surfaces.end(), two_sided);
    measureAll();
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
      const Surface& s = surfaces[i];
      if (!s.double_sided) out_.roots_[i] = divide(s.first_triangle, s.triangle_count);
    }
    reorder();
    out_.clusters_.shrink_to_fit();
    return std::move(out_);
  }

 private:
  /// A triangle by itself, so that sorting and bounding read what lies side by side.
  struct Member {
    glm::dvec3 normal;       ///< of length 1; 0 if not known
    double error;            ///< of the normal, as a vector
    glm::vec3 corner;        ///< its first
    std::uint32_t triangle;  ///< of the mesh
  };
  using Members = std::span<Member>;
  /// Where members lie, and where their normals point.
  struct Extent {
    glm::vec3 low{std::numeric_limits<float>::infinity()}, high = -low;
    glm::dvec3 least{kInf}, most{-kInf};
  };

  void measureAll() {
    members_.reserve(mesh_.triangles.size());
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) members_.push_back(measured(t));
    const glm::dvec3 side = mesh_.bounds.max - mesh_.bounds.min;
    const double size = std::max({side.x, side.y, side.z});
    per_size_ = size > 0.0 ? 1.0 / size : 0.0;
  }

  Member measured(std::uint32_t t) const {
    const auto& corners = mesh_.triangles[t];
    const glm::dvec3 p(mesh_.positions[corners[0]]);
    const glm::dvec3 a = glm::dvec3(mesh_.positions[corners[1]]) - p;
    const glm::dvec3 b = glm::dvec3(mesh_.positions[corners[2]]) - p;
    const glm::dvec3 n = glm::cross(a, b);
    const double length = glm::length(n);
    const double error = 32.0 * kUnit * sumAbs(a) * sumAbs(b) / length + 8.0 * kUnit;
    const bool known = error < kMostNormalError;  // false for NaN
    return {known ? n / length : glm::dvec3(0.0), known ? error : kInf, mesh_.positions[corners[0]],
            t};
  }

  std::uint32_t divide(std::uint32_t first, std::uint32_t count) {
    const auto index = static_cast<std::uint32_t>(out_.clusters_.size());
    const Members members(&members_[first], count);
    Extent extent;
    out_.clusters_.push_back(clusterOf(members, extent));
    out_.clusters_[index].first = first;
    out_.clusters_[index].count = count;
    if (count <= rules_.leaf) return index;
    const std::uint32_t half = count / 2;
    if (const std::optional<int> key = widestKey(extent)) {
      const int axis = *key % 3;
      *key < 3 ? halve(
                     members, [axis](const Member& m) { return m.corner[axis]; })
               : halve(
                     members, [axis](const Member& m) { return m.normal[axis]; });
    }
    divide(first, half);
    const std::uint32_t right = divide(first + half, count - half);
    out_.clusters_[index].right = right;
    return index;
  }

  template <typename KeyOf>
  static void halve(Members members, const KeyOf& key_of) {
    const auto middle = members.begin() + static_cast<std::ptrdiff_t>(members.size() / 2);
    std::nth_element(members.begin(), middle, members.end(), [&](const Member& a, const Member& b) {
      const auto x = key_of(a), y = key_of(b);
      return x < y || (x == y && a.triangle < b.triangle);
    });
  }

  /// Where members differ most: 0-2 by place, as a share of the mesh's size; 3-5 by normal. None if
  /// nothing may divide them.
  std::optional<int> widestKey(const Extent& extent) const {
    const glm::dvec3 place = per_size_ * (glm::dvec3(extent.high) - glm::dvec3(extent.low));
    const glm::dvec3 normal = extent.most - extent.least;
    std::optional<int> best;
    double widest = -1.0;
    for (int key = 0; key < 6; ++key) {
      if (!(key < 3 ? rules_.by_position : rules_.by_normal)) continue;
      const double width = key < 3 ? place[key] : normal[key - 3];
      if (width > widest) {
        widest = width;
        best = key;
      }
    }
    return best;
  }

  FacingClusters::Cluster clusterOf(Members members, Extent& extent) const {
    FacingClusters::Cluster c{};
    glm::dvec3 sum(0.0), middle(0.0);
    double error = 0.0;
    for (const Member& m : members) {
      sum += m.normal;
      middle += glm::dvec3(m.corner);
      error = std::max(error, m.error);
      extent.low = glm::min(extent.low, m.corner);
      extent.high = glm::max(extent.high, m.corner);
      extent.least = glm::min(extent.least, m.normal);
      extent.most = glm::max(extent.most, m.normal);
    }
    const double length = glm::length(sum);
    if (!(length > 0.0) || !(error < kMostNormalError)) return c;
    c.axis = sum / length;
    c.middle = middle / static_cast<double>(members.size());
    bound(members, error, c);
    return c;
  }

  /// The least cone around the axis, and the least distances from the middle to planes, that hold
  /// for all members.
  void bound(Members members, double error, FacingClusters::Cluster& c) const {
    double least = 1.0, sine = 0.0;
    c.above = -kInf;  // but `below` is 0 at least: regionOf() rests on that
    for (const Member& m : members) {
      least = std::min(least, glm::dot(c.axis, m.normal));
      const glm::dvec3 across = glm::cross(c.axis, m.normal);
      sine = std::max(sine, glm::dot(across, across));
      const glm::dvec3 to = c.middle - glm::dvec3(m.corner);
      const double height = glm::dot(m.normal, to);
      c.below = std::max(c.below, height + 2.0 * (m.error + 8.0 * kUnit) * sumAbs(to));
      c.above = std::max(c.above, -height);
    }
    c.sine = std::sqrt(sine) + error + kAngleError;
    c.certain = least > 0.0 && c.sine < kMostSine && std::isfinite(c.below);
    if (c.certain) c.cosine = std::sqrt(1.0 - c.sine * c.sine) - kCosineError;
  }

  void reorder() {
    std::vector<std::uint32_t> place(members_.size());
    for (std::uint32_t i = 0; i < members_.size(); ++i) place[members_[i].triangle] = i;
    out_.triangles_.reserve(members_.size());
    out_.partners_.reserve(3 * members_.size());
    for (const Member& m : members_) {
      out_.triangles_.push_back(mesh_.triangles[m.triangle]);
      for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t p = mesh_.partners[3 * m.triangle + e];
        out_.partners_.push_back(p == kOpenEdge ? kOpenEdge : 3 * place[p / 3] + p % 3);
      }
    }
  }

  const Mesh& mesh_;
  const ClusterRules& rules_;
  std::vector<Member> members_;  ///< surfaces stay in place
  double per_size_ = 0.0;
  FacingClusters out_;
};

FacingClusters FacingClusters::of(const Mesh& mesh, const ClusterRules& rules) {
  return ClusterBuilder(mesh, rules).run();
}

}  // namespace culld
