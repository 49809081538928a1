#include "culling/occluders/solid_hulls.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include "culling/core/sum_abs.h"
#include "culling/occluders/closed_parts.h"
#include "culling/occluders/convex_hull.h"

namespace culld {
namespace {

constexpr double kShrink = 1.0 - 0x1p-10;  ///< leaves room between a hull and the part around it
constexpr int kMostCuts = 8;
constexpr double kLeastDepth = 0.01;  ///< of the part's size: cuts stay that far from the centre
constexpr double kClearance = 1e-3;   ///< of the part's size, where its inside is told
constexpr std::size_t kMostCentres = 8, kMostHullsOfPart = 3;
constexpr std::size_t kIntrudingShare = 4;  ///< one triangle of so many: too far from convex

using Points = std::vector<glm::dvec3>;

struct HalfSpace {
  glm::dvec3 normal;  ///< outwards
  double offset;      ///< normal . x <= offset
};

double mostAlong(const glm::dvec3& axis, std::span<const glm::dvec3> points) {
  double most = -std::numeric_limits<double>::infinity();
  for (const glm::dvec3& p : points) most = std::max(most, glm::dot(axis, p));
  return most;
}

std::array<glm::dvec3, 3> cornersOf(const Mesh& mesh, std::uint32_t t) {
  const auto& v = mesh.triangles[t];
  return {glm::dvec3(mesh.positions[v[0]]), glm::dvec3(mesh.positions[v[1]]),
          glm::dvec3(mesh.positions[v[2]])};
}

/// A body held against triangles: finds for each a plane between the two.
class Separation {
 public:
  /// `axes`: directions to try, any will do. `centre`: one of `points`.
  Separation(std::span<const glm::dvec3> points, std::span<const glm::dvec3> axes,
             const glm::dvec3& centre, double size, double largest)
      : points_(points), centre_(centre), clearance_(kClearance * size), largest_(largest) {
    for (const glm::dvec3& axis : axes) planes_.push_back({axis, mostAlong(axis, points)});
  }

  /// Sure of it, and that the triangle stays clear of the centre.
  bool apart(const std::array<glm::dvec3, 3>& t) const {
    for (const HalfSpace& plane : planes_) {
      if (beyond(plane, t)) return true;
    }
    const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
    return beyond({n, mostAlong(n, points_)}, t) || beyond({-n, mostAlong(-n, points_)}, t);
  }

 private:
  bool beyond(const HalfSpace& plane, const std::array<glm::dvec3, 3>& t) const {
    const glm::dvec3& n = plane.normal;
    const double least = std::min({glm::dot(n, t[0]), glm::dot(n, t[1]), glm::dot(n, t[2])});
    // A dot product of exact numbers makes 5 roundings of its terms.
    const double margin = 16.0 * 0x1p-53 * sumAbs(n) * largest_ + 1e-300;
    return least - plane.offset > margin &&
           least - glm::dot(n, centre_) > clearance_ * glm::length(n) + margin;
  }

  std::span<const glm::dvec3> points_;
  glm::dvec3 centre_;
  double clearance_, largest_;
  std::vector<HalfSpace> planes_;
};

/// How many times the surface winds around the point, times 4 pi (van Oosterom, Strackee 1983).
double solidAngle(const Mesh& mesh, std::span<const std::uint32_t> part, const glm::dvec3& from) {
  double sum = 0.0;
  for (const std::uint32_t t : part) {
    const auto p = cornersOf(mesh, t);
    const glm::dvec3 a = glm::normalize(p[0] - from), b = glm::normalize(p[1] - from),
                     c = glm::normalize(p[2] - from);
    sum += 2.0 * std::atan2(glm::dot(a, glm::cross(b, c)),
                            1.0 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a));
  }
  return sum;
}

double sizeOf(const Box& box) { return glm::length(box.max - box.min); }
double largestOf(const Box& box) {
  const glm::dvec3 most = glm::max(glm::abs(box.min), glm::abs(box.max));
  return std::max({most.x, most.y, most.z});
}

glm::dvec3 meanOf(std::span<const glm::dvec3> points) {
  glm::dvec3 sum(0.0);
  for (const glm::dvec3& p : points) sum += p / static_cast<double>(points.size());
  return sum;
}

}  // namespace

bool surelyInside(std::span<const glm::vec3> vertices, const Mesh& mesh,
                  std::span<const std::uint32_t> part, bool any_side) {
  Points points(vertices.begin(), vertices.end());
  const glm::dvec3 centre = meanOf(points);
  points.push_back(centre);  // however it was rounded, it counts as one of them
  Box box = boxOfTriangles(mesh, part);
  const double size = sizeOf(box);
  for (const glm::dvec3& p : points) box.grow(p);
  Points axes;
  const ConvexHull hull = convexHull(points);
  for (const auto& t : hull.triangles) {
    axes.push_back(glm::cross(points[t[1]] - points[t[0]], points[t[2]] - points[t[0]]));
  }
  const Separation separation(points, axes, centre, size, largestOf(box));
  const bool apart = std::all_of(part.begin(), part.end(), [&](std::uint32_t t) {
    return separation.apart(cornersOf(mesh, t));
  });
  if (!apart) return false;
  const double windings = solidAngle(mesh, part, centre) / (4.0 * std::numbers::pi);
  const double whole = std::round(windings);
  return std::abs(windings - whole) < 0.01 && (whole >= 1.0 || (any_side && whole != 0.0));
}

namespace {

/// A convex body that is cut down until the part around it does not reach into it.
class Body {
 public:
  /// False: the points span no body.
  bool span(Points points) {
    ConvexHull hull = convexHull(points);
    if (hull.corners.size() > kMostPieceVertices) {
      points = spread(points, hull.corners);
      hull = convexHull(points);
    }
    if (hull.empty()) return false;
    corners_.clear();
    triangles_.clear();
    for (const std::uint32_t corner : hull.corners) corners_.push_back(points[corner]);
    for (auto t : hull.triangles) {
      for (std::uint32_t& corner : t) {
        const auto at = std::lower_bound(hull.corners.begin(), hull.corners.end(), corner);
        corner = static_cast<std::uint32_t>(at - hull.corners.begin());
      }
      triangles_.push_back(t);
    }
    return true;
  }

  bool cut(const HalfSpace& plane) {
    Points left;
    std::vector<double> over;
    for (const glm::dvec3& p : corners_) {
      over.push_back(glm::dot(plane.normal, p) - plane.offset);
      if (over.back() <= 0.0) left.push_back(p);
    }
    for (const auto& t : triangles_) {
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t i = t[e], j = t[(e + 1) % 3];
        if (!(i < j) || (over[i] <= 0.0) == (over[j] <= 0.0)) continue;
        left.push_back(corners_[i] + over[i] / (over[i] - over[j]) * (corners_[j] - corners_[i]));
      }
    }
    return span(std::move(left));
  }

  Points shrunk(const glm::dvec3& centre) const {
    Points points;
    for (const glm::dvec3& p : corners_) points.push_back(centre + kShrink * (p - centre));
    return points;
  }
  Points normals() const {
    Points out;
    for (const auto& t : triangles_) {
      const glm::dvec3& p = corners_[t[0]];
      out.push_back(glm::cross(corners_[t[1]] - p, corners_[t[2]] - p));
    }
    return out;
  }
  double volume() const {
    double sum = 0.0;
    for (const auto& t : triangles_)
      sum += glm::dot(corners_[t[0]], glm::cross(corners_[t[1]], corners_[t[2]])) / 6.0;
    return sum;
  }
  bool holds(const glm::dvec3& x) const {
    const Points axes = normals();
    for (std::size_t t = 0; t < axes.size(); ++t) {
      if (glm::dot(axes[t], x - corners_[triangles_[t][0]]) > 0.0) return false;
    }
    return true;
  }
  const Points& corners() const { return corners_; }
  const std::vector<std::array<std::uint32_t, 3>>& triangles() const { return triangles_; }

 private:
  /// Those farthest along directions spread evenly: a hull of these is within the hull of all.
  static Points spread(const Points& points, std::span<const std::uint32_t> corners) {
    Points out;
    for (std::size_t i = 0; i < kMostPieceVertices; ++i) {
      const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / kMostPieceVertices;
      const double turn = std::numbers::phi * 2.0 * std::numbers::pi * static_cast<double>(i);
      const double r = std::sqrt(1.0 - z * z);
      const glm::dvec3 axis(r * std::cos(turn), r * std::sin(turn), z);
      const std::uint32_t best =
          *std::max_element(corners.begin(), corners.end(), [&](std::uint32_t a, std::uint32_t b) {
            return glm::dot(axis, points[a]) < glm::dot(axis, points[b]);
          });
      if (std::find(out.begin(), out.end(), points[best]) == out.end()) out.push_back(points[best]);
    }
    return out;
  }

  Points corners_;
  std::vector<std::array<std::uint32_t, 3>> triangles_;
};

/// One closed part.
class Solid {
 public:
  Solid(const Mesh& mesh, std::span<const std::uint32_t> part, bool any_side)
      : mesh_(mesh), part_(part), any_side_(any_side), box_(boxOfTriangles(mesh, part)) {}

  /// Appends hulls, the largest first, each of which reaches where those before do not.
  void appendHulls(std::vector<SolidHull>& hulls) {
    Points points;
    for (const std::uint32_t t : part_) {
      for (const glm::dvec3& p : cornersOf(mesh_, t)) points.push_back(p);
    }
    Body whole;
    if (!whole.span(std::move(points))) return;
    std::vector<Fitted> found;
    for (const glm::dvec3& centre : centresOf(whole)) {
      body_ = whole;
      centre_ = centre;
      const Fit fit = this->fit();
      if (fit == Fit::kFits) found.push_back({body_, centre_, body_.volume()});
      if (fit == Fit::kHopeless || (fit == Fit::kFits && found.size() == 1 && !was_cut_)) break;
    }
    std::stable_sort(found.begin(), found.end(),
                     [](const Fitted& a, const Fitted& b) { return a.volume > b.volume; });
    std::vector<const Fitted*> taken;
    for (const Fitted& fitted : found) {
      const bool covered = std::any_of(taken.begin(), taken.end(), [&](const Fitted* other) {
        return other->body.holds(fitted.centre);
      });
      if (covered || taken.size() == kMostHullsOfPart) continue;
      SolidHull hull = packed(fitted);
      if (hull.vertices.empty() || !surelyInside(hull.vertices, mesh_, part_, any_side_)) continue;
      taken.push_back(&fitted);
      hulls.push_back(std::move(hull));
    }
  }

 private:
  enum class Fit { kFits, kNot, kHopeless };
  struct Fitted {
    Body body;
    glm::dvec3 centre;
    double volume;
  };

  /// Where bodies may grow around: the middle of all, then the middles of the part's thickness
  /// below its largest triangles.
  Points centresOf(const Body& whole) const {
    std::vector<std::pair<double, std::uint32_t>> by_size;
    for (const std::uint32_t t : part_) {
      const auto p = cornersOf(mesh_, t);
      by_size.emplace_back(-glm::length(glm::cross(p[1] - p[0], p[2] - p[0])), t);
    }
    const std::size_t most = std::min(kMostCentres, by_size.size());
    std::partial_sort(by_size.begin(), by_size.begin() + static_cast<std::ptrdiff_t>(most),
                      by_size.end());
    Points centres{meanOf(whole.corners())};
    for (std::size_t i = 0; i < most; ++i) {
      const auto p = cornersOf(mesh_, by_size[i].second);
      const glm::dvec3 from = meanOf(p), inwards = glm::cross(p[2] - p[0], p[1] - p[0]);
      const double thickness = wayOut(from, inwards, by_size[i].second);
      if (std::isfinite(thickness)) centres.push_back(from + 0.5 * thickness * inwards);
    }
    return centres;
  }

  /// How many steps lead from a triangle through the part to its other side. Infinite: there is
  /// none.
  double wayOut(const glm::dvec3& from, const glm::dvec3& step, std::uint32_t start) const {
    double least = std::numeric_limits<double>::infinity();
    for (const std::uint32_t t : part_) {
      const auto p = cornersOf(mesh_, t);
      const glm::dvec3 a = p[0] - from, b = p[1] - from, c = p[2] - from;
      const double u = glm::dot(step, glm::cross(a, b)), v = glm::dot(step, glm::cross(b, c)),
                   w = glm::dot(step, glm::cross(c, a));
      const bool through = (u >= 0 && v >= 0 && w >= 0) || (u <= 0 && v <= 0 && w <= 0);
      const glm::dvec3 n = glm::cross(b - a, c - a);
      const double steps = glm::dot(n, a) / glm::dot(n, step);
      if (t != start && through && steps > 0.0) least = std::min(least, steps);
    }
    return least;
  }

  /// Cuts off what the part's own triangles reach into.
  Fit fit() {
    was_cut_ = false;
    for (int cuts = 0; cuts <= kMostCuts; ++cuts) {
      const Points points = body_.shrunk(centre_), normals = body_.normals();
      const Separation separation(points, normals, centre_, sizeOf(box_), largestOf(box_));
      std::optional<Cut> best;
      std::size_t intruding = 0;
      for (const std::uint32_t t : part_) {
        const auto corners = cornersOf(mesh_, t);
        if (separation.apart(corners)) continue;
        if (++intruding > std::max<std::size_t>(part_.size() / kIntrudingShare, 8))
          return cuts == 0 ? Fit::kHopeless : Fit::kNot;
        const std::optional<Cut> cut = cutAlong(corners);
        if (cut && (!best || cut->worth > best->worth)) best = cut;
      }
      if (intruding == 0) return Fit::kFits;
      if (!best || !body_.cut(best->plane)) return Fit::kNot;
      was_cut_ = true;
    }
    return Fit::kNot;
  }

  struct Cut {
    HalfSpace plane;
    double worth;
  };

  /// The triangle's plane, turned away from the centre, unless it is too near to that. Worth more
  /// the less it cuts, and most if the centre is behind the triangle: such a plane may bound all of
  /// what is around the centre.
  std::optional<Cut> cutAlong(const std::array<glm::dvec3, 3>& t) const {
    const glm::dvec3 n = glm::cross(t[1] - t[0], t[2] - t[0]);
    const double length = glm::length(n), size = sizeOf(box_);
    if (!(length > 0.0)) return std::nullopt;
    const HalfSpace plane{n / length, glm::dot(n, t[0]) / length};
    const double depth = plane.offset - glm::dot(plane.normal, centre_);
    if (!(std::abs(depth) > kLeastDepth * size)) return std::nullopt;
    if (depth > 0.0) return Cut{plane, depth + size};
    return Cut{{-plane.normal, -plane.offset}, -depth};
  }

  SolidHull packed(const Fitted& fitted) const {
    SolidHull out;
    out.box_mesh = box_;
    const auto& triangles = fitted.body.triangles();
    if (fitted.body.corners().size() > kMostPieceVertices || triangles.size() > kMostPieceFaces)
      return out;
    for (const auto& t : triangles) {
      out.faces.push_back({{static_cast<std::uint8_t>(t[0]), static_cast<std::uint8_t>(t[1]),
                            static_cast<std::uint8_t>(t[2])}});
    }
    for (std::size_t left = 0; left < triangles.size(); ++left) {
      for (std::size_t e = 0; e < 3; ++e) {
        const std::uint32_t from = triangles[left][e], to = triangles[left][(e + 1) % 3];
        if (from > to) continue;
        out.edges.push_back({static_cast<std::uint8_t>(from), static_cast<std::uint8_t>(to),
                             static_cast<std::uint8_t>(left), faceWith(triangles, to, from)});
      }
    }
    for (const glm::dvec3& p : fitted.body.shrunk(fitted.centre)) out.vertices.emplace_back(p);
    return out;
  }

  /// The triangle that runs along that edge in that direction.
  static std::uint8_t faceWith(std::span<const std::array<std::uint32_t, 3>> triangles,
                               std::uint32_t from, std::uint32_t to) {
    const auto at = std::find_if(triangles.begin(), triangles.end(), [&](const auto& t) {
      return (t[0] == from && t[1] == to) || (t[1] == from && t[2] == to) ||
             (t[2] == from && t[0] == to);
    });
    return static_cast<std::uint8_t>(at - triangles.begin());
  }

  const Mesh& mesh_;
  std::span<const std::uint32_t> part_;
  bool any_side_;
  Box box_;
  glm::dvec3 centre_{0.0};  ///< of the body that is being fitted
  Body body_;
  bool was_cut_ = false;
};

}  // namespace

std::vector<SolidHull> solidHulls(const Mesh& mesh) {
  std::vector<SolidHull> hulls;
  for (const ClosedPart& part : closedParts(mesh, kMostSolidTriangles, kMostSolids))
    Solid(mesh, part.triangles, part.two_sided).appendHulls(hulls);
  return hulls;
}

}  // namespace culld
