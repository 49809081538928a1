// How clusters are made: each surface's triangles are halved where their places or their normals
// differ most. Every bound that facing rests on is verified here, triangle by triangle, against the
// numbers that are stored (docs/error-model/backface-clusters.md §2).
#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numeric>
#include <utility>

#include "culling/occluders/facing_clusters.h"

namespace culld {
namespace {

constexpr double kUnit = 0x1p-53;
constexpr double kAngleError = 1e-14;      ///< of what is computed from vectors of length 1
constexpr double kMostSine = 0.9999995;    ///< of a cone: its cosine is above 1e-3, and ...
constexpr double kCosineError = 1e-12;     ///< ... known to this
constexpr double kMostNormalError = 1e-6;  ///< worse, and a triangle's facing is not asked
constexpr double kInf = std::numeric_limits<double>::infinity();

double sumAbs(const glm::dvec3& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

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
  using Members = std::span<const std::uint32_t>;

  glm::dvec3 corner(std::uint32_t t, std::size_t i) const {
    return glm::dvec3(mesh_.positions[mesh_.triangles[t][i]]);
  }

  void measureAll() {
    order_.resize(mesh_.triangles.size());
    std::iota(order_.begin(), order_.end(), 0U);
    normals_.resize(order_.size());
    errors_.resize(order_.size());
    for (std::uint32_t t = 0; t < order_.size(); ++t) measure(t);
    const glm::dvec3 side = mesh_.bounds.max - mesh_.bounds.min;
    const double size = std::max({side.x, side.y, side.z});
    per_size_ = size > 0.0 ? 1.0 / size : 0.0;
  }

  void measure(std::uint32_t t) {
    const glm::dvec3 a = corner(t, 1) - corner(t, 0), b = corner(t, 2) - corner(t, 0);
    const glm::dvec3 n = glm::cross(a, b);
    const double length = glm::length(n);
    normals_[t] = n / length;
    errors_[t] = 32.0 * kUnit * sumAbs(a) * sumAbs(b) / length + 8.0 * kUnit;
    if (!(errors_[t] < kMostNormalError)) {  // NaN too
      errors_[t] = kInf;
      normals_[t] = glm::dvec3(0.0);
    }
  }

  std::uint32_t divide(std::uint32_t first, std::uint32_t count) {
    const auto index = static_cast<std::uint32_t>(out_.clusters_.size());
    out_.clusters_.push_back(clusterOf(first, count));
    if (count <= rules_.leaf) return index;
    const std::uint32_t half = count / 2;
    const auto begin = order_.begin() + first;
    if (const std::optional<std::size_t> key = widestKey({&order_[first], count})) {
      std::nth_element(begin, begin + half, begin + count, [&](std::uint32_t a, std::uint32_t b) {
        const double x = keyOf(a, *key), y = keyOf(b, *key);
        return x < y || (x == y && a < b);
      });
    }
    divide(first, half);
    const std::uint32_t right = divide(first + half, count - half);
    out_.clusters_[index].right = right;
    return index;
  }

  /// Keys 0-2: place, as a share of the mesh's size; 3-5: normal.
  double keyOf(std::uint32_t t, std::size_t key) const {
    const auto axis = static_cast<int>(key % 3);
    return key < 3 ? corner(t, 0)[axis] * per_size_ : normals_[t][axis];
  }

  /// Where members differ most. None if nothing may divide them.
  std::optional<std::size_t> widestKey(Members members) const {
    std::optional<std::size_t> best;
    double widest = -1.0;
    for (std::size_t key = 0; key < 6; ++key) {
      if (!(key < 3 ? rules_.by_position : rules_.by_normal)) continue;
      double low = kInf, high = -kInf;
      for (const std::uint32_t t : members) {
        low = std::min(low, keyOf(t, key));
        high = std::max(high, keyOf(t, key));
      }
      if (high - low > widest) {
        widest = high - low;
        best = key;
      }
    }
    return best;
  }

  FacingClusters::Cluster clusterOf(std::uint32_t first, std::uint32_t count) const {
    FacingClusters::Cluster c{};
    c.first = first;
    c.count = count;
    const Members members(&order_[first], count);
    glm::dvec3 sum(0.0), middle(0.0);
    double error = 0.0;
    for (const std::uint32_t t : members) {
      sum += normals_[t];
      error = std::max(error, errors_[t]);
      middle += corner(t, 0) / static_cast<double>(count);
    }
    const double length = glm::length(sum);
    if (!(length > 0.0)) return c;
    c.axis = sum / length;
    double least = 1.0, sine = 0.0;
    for (const std::uint32_t t : members) {
      least = std::min(least, glm::dot(c.axis, normals_[t]));
      sine = std::max(sine, glm::length(glm::cross(c.axis, normals_[t])));
    }
    c.sine = sine + error + kAngleError;
    c.certain = least > 0.0 && c.sine < kMostSine;
    if (!c.certain) return c;
    c.cosine = std::sqrt(1.0 - c.sine * c.sine) - kCosineError;
    setTips(members, middle, c);
    return c;
  }

  /// From the middle along the axis, far enough to be behind (in front of) every plane.
  void setTips(Members members, const glm::dvec3& middle, FacingClusters::Cluster& c) const {
    double back = 0.0, forth = 0.0;
    for (const std::uint32_t t : members) {
      const double height =
          glm::dot(normals_[t], middle - corner(t, 0)) / glm::dot(c.axis, normals_[t]);
      back = std::max(back, height);
      forth = std::max(forth, -height);
    }
    c.behind = middle - back * c.axis;
    c.in_front = middle + forth * c.axis;
    for (const std::uint32_t t : members) {
      const glm::dvec3 to = c.behind - corner(t, 0);
      const double most = glm::dot(normals_[t], to) + 2.0 * (errors_[t] + 8.0 * kUnit) * sumAbs(to);
      c.slack = std::max(c.slack, most);
    }
    c.certain = std::isfinite(c.slack) && std::isfinite(sumAbs(c.in_front));
  }

  void reorder() {
    std::vector<std::uint32_t> place(order_.size());
    for (std::uint32_t i = 0; i < order_.size(); ++i) place[order_[i]] = i;
    out_.triangles_.reserve(order_.size());
    out_.partners_.reserve(3 * order_.size());
    for (const std::uint32_t t : order_) {
      out_.triangles_.push_back(mesh_.triangles[t]);
      for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t p = mesh_.partners[3 * t + e];
        out_.partners_.push_back(p == kOpenEdge ? kOpenEdge : 3 * place[p / 3] + p % 3);
      }
    }
  }

  const Mesh& mesh_;
  const ClusterRules& rules_;
  std::vector<std::uint32_t> order_;  ///< triangles; surfaces stay in place
  std::vector<glm::dvec3> normals_;   ///< of length 1; 0 if not known
  std::vector<double> errors_;        ///< of normals, as vectors
  double per_size_ = 0.0;
  FacingClusters out_;
};

FacingClusters FacingClusters::of(const Mesh& mesh, const ClusterRules& rules) {
  return ClusterBuilder(mesh, rules).run();
}

}  // namespace culld
