#include "culling/occluders/convex_hull.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <glm/common.hpp>
#include <map>
#include <memory>
#include <utility>

extern "C" {
#include <libqhull_r/libqhull_r.h>
}

namespace culld {
namespace {

constexpr double kFlat = 1e-9;  ///< volume of a hull of size 1 that only joggling has given room

struct FileCloser {
  void operator()(std::FILE* file) const noexcept { std::fclose(file); }
};

/// One run of Qhull.
class QhullRun {
 public:
  QhullRun() { qh_zero(&qhull_, nullptr); }
  ~QhullRun() {
    qh_freeqhull(&qhull_, !qh_ALL);
    int blocks = 0, bytes = 0;
    qh_memfreeshort(&qhull_, &blocks, &bytes);
  }
  QhullRun(const QhullRun&) = delete;
  QhullRun& operator=(const QhullRun&) = delete;

  /// False if Qhull gave up. `command`: its options.
  bool compute(std::vector<double>& coordinates, std::string command) {
    const std::unique_ptr<std::FILE, FileCloser> nowhere(std::fopen("/dev/null", "w"));
    if (!nowhere) return false;
    const int count = static_cast<int>(coordinates.size() / 3);
    return qh_new_qhull(&qhull_, 3, count, coordinates.data(), False, command.data(), nullptr,
                        nowhere.get()) == 0;
  }

  /// Facets of more than three corners are not expected: they are left out.
  std::vector<std::array<std::uint32_t, 3>> triangles() {
    std::vector<std::array<std::uint32_t, 3>> out;
    for (const facetT* facet = qhull_.facet_list; facet != nullptr && facet->next != nullptr;
         facet = facet->next) {
      std::array<std::uint32_t, 3> corner{};
      std::size_t corners = 0;
      for (void* const* at = &facet->vertices->e[0].p; *at != nullptr; ++at, ++corners) {
        const auto* vertex = static_cast<const vertexT*>(*at);
        if (corners < 3)
          corner[corners] = static_cast<std::uint32_t>(qh_pointid(&qhull_, vertex->point));
      }
      if (corners == 3) out.push_back(corner);
    }
    return out;
  }

 private:
  qhT qhull_;
};

/// Moved and scaled to about [-1, 1]. Empty if that cannot be done.
std::vector<double> normalized(std::span<const glm::dvec3> points) {
  glm::dvec3 low(points[0]), high(points[0]);
  for (const glm::dvec3& p : points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const glm::dvec3 centre = 0.5 * low + 0.5 * high, side = high - low;
  const double scale = 2.0 / std::max({side.x, side.y, side.z});
  if (!std::isfinite(scale)) return {};
  std::vector<double> out;
  out.reserve(3 * points.size());
  for (const glm::dvec3& p : points) {
    for (int axis = 0; axis < 3; ++axis) {
      const double x = (p[axis] - centre[axis]) * scale;
      if (!std::isfinite(x)) return {};
      out.push_back(x);
    }
  }
  return out;
}

/// Turns each triangle outwards, as Qhull lists corners in no certain order. Returns six times the
/// volume.
double turnOutwards(std::span<const glm::dvec3> points, ConvexHull& hull) {
  glm::dvec3 inside(0.0);
  double sum = 0.0;
  for (const std::uint32_t corner : hull.corners)
    inside += points[corner] / static_cast<double>(hull.corners.size());
  for (auto& t : hull.triangles) {
    const glm::dvec3 a = points[t[0]] - inside, b = points[t[1]] - inside,
                     c = points[t[2]] - inside;
    const double volume = a.x * (b.y * c.z - b.z * c.y) + a.y * (b.z * c.x - b.x * c.z) +
                          a.z * (b.x * c.y - b.y * c.x);
    if (volume < 0.0) std::swap(t[1], t[2]);
    sum += std::abs(volume);
  }
  return sum;
}

double longestSide(std::span<const glm::dvec3> points) {
  glm::dvec3 low(points[0]), high(points[0]);
  for (const glm::dvec3& p : points) {
    low = glm::min(low, p);
    high = glm::max(high, p);
  }
  const glm::dvec3 side = high - low;
  return std::max({side.x, side.y, side.z});
}

/// Every edge is run along once each way.
bool closed(const ConvexHull& hull) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> runs;
  for (const auto& t : hull.triangles) {
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint32_t from = t[e], to = t[(e + 1) % 3];
      if (++runs[{from, to}] > 1) return false;
    }
  }
  return std::all_of(runs.begin(), runs.end(), [&](const auto& run) {
    return runs.contains({run.first.second, run.first.first});
  });
}

ConvexHull computed(std::span<const glm::dvec3> points, std::vector<double>& coordinates,
                    const char* command) {
  ConvexHull hull;
  QhullRun run;
  if (!run.compute(coordinates, command)) return {};
  hull.triangles = run.triangles();
  for (const auto& t : hull.triangles) hull.corners.insert(hull.corners.end(), t.begin(), t.end());
  std::sort(hull.corners.begin(), hull.corners.end());
  hull.corners.erase(std::unique(hull.corners.begin(), hull.corners.end()), hull.corners.end());
  const double side = longestSide(points);
  const bool flat = !(turnOutwards(points, hull) > kFlat * side * side * side);
  return closed(hull) && !flat ? hull : ConvexHull{};
}

}  // namespace

ConvexHull convexHull(std::span<const glm::dvec3> points) {
  if (points.size() < 4) return {};
  std::vector<double> coordinates = normalized(points);
  if (coordinates.empty()) return {};
  // Merged facets cut into triangles; where that fails, joggled points, which need no merging.
  ConvexHull hull = computed(points, coordinates, "qhull Qt Pp");
  if (hull.empty()) hull = computed(points, coordinates, "qhull QJ Pp");
  return hull;
}

}  // namespace culld
