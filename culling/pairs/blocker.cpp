#include "culling/pairs/blocker.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace culld {
namespace {

/// A piece's vertices in world space.
struct WorldPiece {
  std::vector<glm::dvec3> vertices;
  double rounding_m = 0.0;  ///< no coordinate is further off
  bool mirrored = false;    ///< its faces run clockwise from the front
  bool usable = false;
};

double largestOf(const glm::dvec3& p) {
  return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
}

/// Below it products may be subnormal, and their roundings no share of them.
constexpr double kTiny = 1e-290;

/// 0 where rounding could decide.
int sideOfMap(const std::array<double, 12>& m) {
  const glm::dvec3 x(m[0], m[1], m[2]), y(m[4], m[5], m[6]), z(m[8], m[9], m[10]);
  const double determinant = glm::dot(x, glm::cross(y, z));
  const double doubt = std::max(kTiny, 0x1p-46 * largestOf(x) * largestOf(y) * largestOf(z));
  if (!(std::abs(determinant) > doubt)) return 0;
  return determinant > 0.0 ? 1 : -1;
}

WorldPiece placed(const ConvexPiece& piece, const Instance& instance) {
  WorldPiece world;
  const auto& m = instance.world_from_mesh;
  const int side = sideOfMap(m);
  world.mirrored = side < 0;
  double terms = 0.0;
  for (const glm::vec3& v : piece.vertices) {
    glm::dvec3 p;
    for (int i = 0; i < 3; ++i) {
      const double* row = m.data() + 4 * i;
      const double x = row[0] * static_cast<double>(v.x), y = row[1] * static_cast<double>(v.y),
                   z = row[2] * static_cast<double>(v.z);
      p[i] = x + y + z + row[3];
      terms = std::max(terms, std::abs(x) + std::abs(y) + std::abs(z) + std::abs(row[3]));
    }
    world.vertices.push_back(p);
  }
  world.rounding_m = 0x1p-50 * terms;
  world.usable = side != 0 && terms < kFarthestPlace;
  return world;
}

std::array<glm::dvec3, 3> cornersOf(const WorldPiece& world, const PieceFace& face) {
  std::array<glm::dvec3, 3> corner = {world.vertices[face.corner[0]],
                                      world.vertices[face.corner[1]],
                                      world.vertices[face.corner[2]]};
  if (world.mirrored) std::swap(corner[1], corner[2]);
  return corner;
}

/// Six times the volume that a plane's corners span with a point: positive in front of it.
struct Volume {
  double value, doubt;
};
Volume volumeOf(const std::array<glm::dvec3, 3>& corner, const glm::dvec3& point,
                double rounding_m) {
  const glm::dvec3 a = corner[1] - corner[0], b = corner[2] - corner[0], p = point - corner[0];
  const double side = std::max(largestOf(a), largestOf(b)), reach = largestOf(p);
  return {glm::dot(glm::cross(a, b), p),
          std::max(kTiny, side * (0x1p-46 * side * reach + 32.0 * rounding_m * (reach + side)))};
}

Box boundsOf(const WorldPiece& world) {
  Box box;
  for (const glm::dvec3& p : world.vertices) box.grow(p);
  return box;
}

bool hasEdge(const PieceEdge& edge, std::size_t face) {
  return edge.left == face || edge.right == face;
}

/// What a dot product with a vector of length 1 can be off at a point so far out.
double dotDoubt(double largest, double distance) {
  return std::max(kTiny, 0x1p-49 * (3.0 * largest + std::abs(distance)));
}

/// The plane of a face, moved to where none of the face's vertices is in it or behind it.
SolidPlane planeOf(const ConvexPiece& piece, std::size_t face, const WorldPiece& world) {
  const auto corner = cornersOf(world, piece.faces[face]);
  SolidPlane plane{glm::normalize(glm::cross(corner[1] - corner[0], corner[2] - corner[0])),
                   std::numeric_limits<double>::infinity(),
                   -std::numeric_limits<double>::infinity()};
  double largest = 0.0;
  for (const glm::dvec3& v : world.vertices) {
    plane.outer = std::max(plane.outer, glm::dot(plane.normal, v));
    largest = std::max(largest, largestOf(v));
  }
  for (const PieceEdge& edge : piece.edges) {
    if (!hasEdge(edge, face)) continue;
    for (const auto end : {edge.from, edge.to}) {
      plane.inner = std::min(plane.inner, glm::dot(plane.normal, world.vertices[end]));
    }
  }
  const double doubt = dotDoubt(largest, 0.0) + 4.0 * world.rounding_m;
  plane.inner -= doubt;
  plane.outer += doubt;
  return plane;
}

bool closed(const ConvexPiece& piece) {
  return std::none_of(piece.edges.begin(), piece.edges.end(),
                      [](const PieceEdge& edge) { return edge.right == kNoFace; });
}

}  // namespace

std::optional<SolidBlocker> SolidBlocker::of(const ConvexPiece& piece, const Instance& instance) {
  const WorldPiece world = placed(piece, instance);
  if (!world.usable || !closed(piece) || piece.faces.size() < 4) return std::nullopt;
  glm::dvec3 centre(0.0);
  for (const glm::dvec3& v : world.vertices)
    centre += v / static_cast<double>(world.vertices.size());
  SolidBlocker solid;
  for (std::size_t f = 0; f < piece.faces.size(); ++f) {
    const SolidPlane plane = planeOf(piece, f, world);
    const Volume behind = volumeOf(cornersOf(world, piece.faces[f]), centre, world.rounding_m);
    const double at_centre = glm::dot(plane.normal, centre);
    // The centre lies inside the surface, and inside what is left of it.
    if (!(behind.value < -behind.doubt)) return std::nullopt;
    if (!(at_centre < plane.inner - dotDoubt(largestOf(centre), plane.inner))) return std::nullopt;
    solid.planes_.push_back(plane);
  }
  solid.planes_.shrink_to_fit();
  solid.bounds_ = boundsOf(world);
  return solid;
}

/// A viewer inside the surface would see out through the backs of its faces.
bool SolidBlocker::outside(const PlaceCorners& viewer) const noexcept {
  return std::any_of(planes_.begin(), planes_.end(), [&](const SolidPlane& plane) {
    const double limit = plane.outer + dotDoubt(viewer.largest, plane.outer);
    return std::all_of(viewer.corner.begin(),
                       viewer.corner.begin() + static_cast<std::ptrdiff_t>(viewer.count),
                       [&](const glm::dvec3& p) { return glm::dot(plane.normal, p) > limit; });
  });
}

/// Clips the segment by each plane (Cyrus, Beck 1978), all distances rounded outwards.
bool SolidBlocker::meets(const glm::dvec3& from, const glm::dvec3& to,
                         double largest) const noexcept {
  double enter = 0.0, leave = 1.0;
  for (const SolidPlane& plane : planes_) {
    const double doubt = dotDoubt(largest, plane.inner);
    const double a = glm::dot(plane.normal, from) - plane.inner + doubt;
    const double b = glm::dot(plane.normal, to) - plane.inner + doubt;
    if (!(a <= 0.0 || b <= 0.0)) return false;  // NaN too
    if (a > 0.0) enter = std::max(enter, a / (a - b));
    if (b > 0.0) leave = std::min(leave, a / (a - b));
  }
  return enter + 0x1p-48 < leave;
}

bool SolidBlocker::hides(const PlaceCorners& viewer, const PlaceCorners& target) const noexcept {
  const double largest = std::max(viewer.largest, target.largest);
  if (!meets(viewer.centre, target.centre, largest) || !outside(viewer)) return false;
  for (std::size_t v = 0; v < viewer.count; ++v) {
    for (std::size_t t = 0; t < target.count; ++t) {
      if (!meets(viewer.corner[v], target.corner[t], largest)) return false;
    }
  }
  return true;
}

void FaceBlocker::append(const ConvexPiece& piece, const Instance& instance,
                         std::vector<FaceBlocker>& out) {
  const WorldPiece world = placed(piece, instance);
  if (!world.usable) return;
  for (std::size_t f = 0; f < piece.faces.size(); ++f) {
    FaceBlocker face;
    face.corner_ = cornersOf(world, piece.faces[f]);
    face.rounding_m_ = world.rounding_m;
    for (const PieceEdge& edge : piece.edges) {
      if (!hasEdge(edge, f)) continue;
      glm::dvec3 from = world.vertices[edge.from], to = world.vertices[edge.to];
      if ((edge.left != f) != world.mirrored) std::swap(from, to);
      face.rim_.push_back({from, to});
      face.bounds_.grow(from);
      face.bounds_.grow(to);
    }
    face.rim_.shrink_to_fit();
    if (!face.rim_.empty()) out.push_back(std::move(face));
  }
}

bool FaceBlocker::inFront(const glm::dvec3& point, double sign) const noexcept {
  const Volume volume = volumeOf(corner_, point, rounding_m_);
  return sign * volume.value > volume.doubt;
}

/// Whether the line winds around the whole rim the same way, so that it passes the face.
bool FaceBlocker::passes(const glm::dvec3& from, const glm::dvec3& to) const noexcept {
  const glm::dvec3 along = to - from;
  const double length = largestOf(along);
  return std::all_of(rim_.begin(), rim_.end(), [&](const RimEdge& edge) {
    const glm::dvec3 a = edge.from - from, b = edge.to - from;
    const double reach = std::max(largestOf(a), largestOf(b));
    const double doubt = std::max(kTiny, length * reach * (0x1p-46 * reach + 32.0 * rounding_m_));
    return glm::dot(along, glm::cross(a, b)) < -doubt;
  });
}

bool FaceBlocker::hides(const PlaceCorners& viewer, const PlaceCorners& target) const noexcept {
  if (!passes(viewer.centre, target.centre)) return false;
  for (std::size_t v = 0; v < viewer.count; ++v) {
    if (!inFront(viewer.corner[v], 1.0)) return false;
  }
  for (std::size_t t = 0; t < target.count; ++t) {
    if (!inFront(target.corner[t], -1.0)) return false;
  }
  for (std::size_t v = 0; v < viewer.count; ++v) {
    for (std::size_t t = 0; t < target.count; ++t) {
      if (!passes(viewer.corner[v], target.corner[t])) return false;
    }
  }
  return true;
}

}  // namespace culld
