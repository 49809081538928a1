#include "culling/occluders/convex_pieces.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numeric>

namespace culld {
namespace {

constexpr double kFlat = 1e-5;  ///< of a part's size: how far behind "behind" may be

/// Union-find with path halving.
class Groups {
 public:
  explicit Groups(std::size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), 0U);
  }
  std::uint32_t find(std::uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(std::uint32_t a, std::uint32_t b) { parent_[find(a)] = find(b); }

 private:
  std::vector<std::uint32_t> parent_;
};

using Corners = std::array<glm::vec3, 3>;

glm::dvec3 normalOf(const Corners& t) {
  const glm::dvec3 p(t[0]);
  return glm::cross(glm::dvec3(t[1]) - p, glm::dvec3(t[2]) - p);
}

/// Which way the triangle turns seen along `axis`; 0 where rounding could decide. Differences of
/// floats lose at most 2^-53 of themselves, a product as much again: four units cover each term.
int turnAlong(const Corners& t, int axis) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  const glm::dvec3 p(t[0]), a = glm::dvec3(t[1]) - p, b = glm::dvec3(t[2]) - p;
  const double plus = a[u] * b[v], minus = a[v] * b[u];
  if (!(std::abs(plus - minus) > 0x1p-50 * (std::abs(plus) + std::abs(minus)))) return 0;
  return plus > minus ? 1 : -1;
}

/// Surely turned the same way in exactly one plane. That holds where a coordinate is the same float
/// throughout; other planes would need exact arithmetic to tell.
bool samePlane(const Corners& a, const Corners& b) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto there = [&](const glm::vec3& p) { return p[axis] == a[0][axis]; };
    if (std::all_of(a.begin(), a.end(), there) && std::all_of(b.begin(), b.end(), there)) {
      const int turn = turnAlong(a, axis);
      return turn != 0 && turn == turnAlong(b, axis);
    }
  }
  return false;
}

}  // namespace

/// One mesh. Parts are joined through partners, faces through partners in one plane.
class PieceFinder {
 public:
  enum class Want : std::uint8_t { kConvexParts, kFaces };
  PieceFinder(const Mesh& mesh, Want want, std::size_t most)
      : mesh_(mesh),
        want_(want),
        most_(most),
        usable_(mesh.triangles.size(), 0),
        part_(mesh.triangles.size()),
        face_(mesh.triangles.size()),
        number_(mesh.positions.size(), kNone) {}

  ConvexPieces run() {
    for (const Surface& s : mesh_.surfaces) {
      if (s.blocks && s.double_sided && want_ == Want::kConvexParts) return {};
      const std::uint8_t sides = s.double_sided ? 2 : 1;
      std::fill_n(usable_.begin() + s.first_triangle, s.triangle_count,
                  s.blocks ? sides : std::uint8_t{0});
    }
    joinNeighbours();
    std::vector<std::uint32_t> order;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (usable_[t] != 0) order.push_back(t);
    }
    std::stable_sort(order.begin(), order.end(), [this](std::uint32_t a, std::uint32_t b) {
      return part_.find(a) < part_.find(b);
    });
    std::vector<Part> parts;
    for (std::size_t begin = 0; begin < order.size();) {
      std::size_t end = begin;
      while (end < order.size() && part_.find(order[end]) == part_.find(order[begin])) ++end;
      parts.push_back(std::span(order).subspan(begin, end - begin));
      begin = end;
    }
    if (want_ == Want::kFaces) keepLargest(parts);
    for (const Part part : parts) {
      const bool added = addPart(part);
      if (!added && want_ == Want::kConvexParts) return {};
    }
    pieces_.triangles_ = static_cast<std::uint32_t>(order.size());
    return std::move(pieces_);
  }

 private:
  static constexpr std::uint32_t kNone = 0xFFFFFFFFU;
  using Part = std::span<const std::uint32_t>;  ///< triangles

  Corners corners(std::uint32_t t) const {
    const auto& v = mesh_.triangles[t];
    return {mesh_.positions[v[0]], mesh_.positions[v[1]], mesh_.positions[v[2]]};
  }

  /// The triangle across edge `e` of `t`, if it is usable too.
  std::uint32_t neighbour(std::uint32_t t, std::uint32_t e) const {
    const std::uint32_t partner = mesh_.partners[3 * t + e];
    return partner != kOpenEdge && usable_[partner / 3] != 0 ? partner / 3 : kNone;
  }

  void joinNeighbours() {
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      if (usable_[t] == 0) continue;
      for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t other = neighbour(t, e);
        if (other == kNone || other < t) continue;
        const bool flat = usable_[t] == usable_[other] && samePlane(corners(t), corners(other));
        if (flat) face_.join(t, other);
        if (flat || want_ == Want::kConvexParts) part_.join(t, other);
      }
    }
  }

  std::uint8_t vertexNumber(std::uint32_t vertex) {
    if (number_[vertex] == kNone) {
      number_[vertex] = static_cast<std::uint32_t>(part_vertices_.size());
      part_vertices_.push_back(vertex);
    }
    return static_cast<std::uint8_t>(number_[vertex]);
  }

  std::uint8_t faceNumber(std::uint32_t t) {
    const std::uint32_t root = face_.find(t);
    const auto at = std::find(part_faces_.begin(), part_faces_.end(), root);
    return static_cast<std::uint8_t>(at - part_faces_.begin());
  }

  void keepLargest(std::vector<Part>& parts) const {
    if (parts.size() <= most_) return;
    std::vector<std::pair<double, std::size_t>> by_area;
    for (std::size_t i = 0; i < parts.size(); ++i) {
      double area = 0.0;
      for (const std::uint32_t t : parts[i]) area += glm::length(normalOf(corners(t)));
      by_area.emplace_back(-area, i);
    }
    std::sort(by_area.begin(), by_area.end());
    std::vector<Part> kept;
    for (std::size_t i = 0; i < most_; ++i) kept.push_back(parts[by_area[i].second]);
    parts = std::move(kept);
  }

  bool addPart(Part triangles) {
    part_vertices_.clear();
    part_faces_.clear();
    if (triangles.size() > 2 * kMostPieceFaces) return false;
    for (const std::uint32_t t : triangles) {
      for (const std::uint32_t v : mesh_.triangles[t]) vertexNumber(v);
      if (face_.find(t) == t) part_faces_.push_back(t);
    }
    const bool small =
        part_vertices_.size() <= kMostPieceVertices && part_faces_.size() <= kMostPieceFaces;
    if (small) {
      for (const std::uint32_t face : part_faces_) addFace(face);
      for (const std::uint32_t t : triangles) addEdges(t);
      for (const std::uint32_t v : part_vertices_) pieces_.vertices_.push_back(mesh_.positions[v]);
      pieces_.ends_.push_back({static_cast<std::uint32_t>(pieces_.vertices_.size()),
                               static_cast<std::uint32_t>(pieces_.faces_.size()),
                               static_cast<std::uint32_t>(pieces_.edges_.size())});
    }
    for (const std::uint32_t v : part_vertices_) number_[v] = kNone;
    if (small && usable_[triangles[0]] == 2) addOtherSide();
    return small && (want_ == Want::kFaces || convex(pieces_[pieces_.size() - 1]));
  }

  void addFace(std::uint32_t t) {
    const auto& v = mesh_.triangles[t];
    pieces_.faces_.push_back({{vertexNumber(v[0]), vertexNumber(v[1]), vertexNumber(v[2])}});
  }

  void addEdges(std::uint32_t t) {
    const auto& v = mesh_.triangles[t];
    for (std::uint32_t e = 0; e < 3; ++e) {
      std::uint32_t other = neighbour(t, e);
      if (other != kNone && part_.find(other) != part_.find(t)) other = kNone;
      if (other != kNone && (other < t || face_.find(other) == face_.find(t))) continue;
      pieces_.edges_.push_back({vertexNumber(v[e]), vertexNumber(v[(e + 1) % 3]), faceNumber(t),
                                other == kNone ? kNoFace : faceNumber(other)});
    }
  }

  /// The last piece once more, turned over.
  void addOtherSide() {
    using End = ConvexPieces::End;
    const End begin = pieces_.ends_.size() < 2 ? End{0, 0, 0} : *(pieces_.ends_.end() - 2);
    const End end = pieces_.ends_.back();
    for (auto i = begin.vertex; i < end.vertex; ++i)
      pieces_.vertices_.push_back(pieces_.vertices_[i]);
    for (auto i = begin.face; i < end.face; ++i) {
      PieceFace face = pieces_.faces_[i];
      std::swap(face.corner[1], face.corner[2]);
      pieces_.faces_.push_back(face);
    }
    for (auto i = begin.edge; i < end.edge; ++i) {
      PieceEdge edge = pieces_.edges_[i];
      std::swap(edge.from, edge.to);
      pieces_.edges_.push_back(edge);
    }
    pieces_.ends_.push_back(
        {2 * end.vertex - begin.vertex, 2 * end.face - begin.face, 2 * end.edge - begin.edge});
  }

  /// Every vertex behind every face; and of an open part, also within its rim.
  static bool convex(const ConvexPiece& piece) {
    double size = 0.0;
    for (const glm::vec3& p : piece.vertices) {
      size = std::max(size, glm::length(glm::dvec3(p) - glm::dvec3(piece.vertices[0])));
    }
    const auto behind = [&](const glm::dvec3& point, const glm::dvec3& normal) {
      const double most = kFlat * size * glm::length(normal);
      return std::all_of(piece.vertices.begin(), piece.vertices.end(), [&](const glm::vec3& p) {
        return glm::dot(glm::dvec3(p) - point, normal) <= most;
      });
    };
    const auto normal = [&](std::uint8_t face) {
      const auto& c = piece.faces[face].corner;
      return normalOf({piece.vertices[c[0]], piece.vertices[c[1]], piece.vertices[c[2]]});
    };
    for (std::size_t f = 0; f < piece.faces.size(); ++f) {
      const auto face = static_cast<std::uint8_t>(f);
      if (!behind(glm::dvec3(piece.vertices[piece.faces[f].corner[0]]), normal(face))) return false;
    }
    for (const PieceEdge& edge : piece.edges) {
      if (edge.right != kNoFace || piece.faces.size() > 1) continue;
      const glm::dvec3 from(piece.vertices[edge.from]), to(piece.vertices[edge.to]);
      if (!behind(from, glm::cross(to - from, normal(edge.left)))) return false;
    }
    return true;
  }

  const Mesh& mesh_;
  const Want want_;
  const std::size_t most_;
  std::vector<std::uint8_t> usable_;   ///< by triangle: so many sides of it block
  Groups part_, face_;                 ///< of triangles
  std::vector<std::uint32_t> number_;  ///< of a mesh vertex within the part, or kNone
  std::vector<std::uint32_t> part_vertices_, part_faces_;
  ConvexPieces pieces_;
};

ConvexPieces ConvexPieces::of(const Mesh& mesh) {
  return PieceFinder(mesh, PieceFinder::Want::kConvexParts, 0).run();
}

ConvexPieces ConvexPieces::facesOf(const Mesh& mesh, std::size_t most) {
  return PieceFinder(mesh, PieceFinder::Want::kFaces, most).run();
}

ConvexPiece ConvexPieces::operator[](std::size_t i) const noexcept {
  const End begin = i == 0 ? End{0, 0, 0} : ends_[i - 1];
  const End end = ends_[i];
  return {std::span(vertices_).subspan(begin.vertex, end.vertex - begin.vertex),
          std::span(faces_).subspan(begin.face, end.face - begin.face),
          std::span(edges_).subspan(begin.edge, end.edge - begin.edge)};
}

std::size_t ConvexPieces::bytes() const noexcept {
  return vertices_.capacity() * sizeof(glm::vec3) + faces_.capacity() * sizeof(PieceFace) +
         edges_.capacity() * sizeof(PieceEdge) + ends_.capacity() * sizeof(End);
}

}  // namespace culld
