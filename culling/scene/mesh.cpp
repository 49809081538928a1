// Welding and edge pairing. Both sort instead of hashing: no input can make them slow.
#include "culling/scene/mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <span>

#include "culling/scene/scene_builder.h"

namespace culld {
namespace {

constexpr std::uint32_t kNotFinite = 0xFFFFFFFFU;

bool finite(const glm::vec3& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// Adding +0 turns -0 into +0 and changes nothing else.
glm::vec3 withoutNegativeZero(const glm::vec3& p) { return {p.x + 0.0F, p.y + 0.0F, p.z + 0.0F}; }

std::vector<glm::vec3> gatherPositions(const std::vector<RawSurface>& surfaces) {
  std::size_t count = 0;
  for (const RawSurface& s : surfaces) count += s.positions.size();
  std::vector<glm::vec3> all;
  all.reserve(count);
  for (const RawSurface& s : surfaces) {
    for (const glm::vec3& p : s.positions) all.push_back(withoutNegativeZero(p));
  }
  return all;
}

/// A position as bits, then its index: finite numbers without -0 are equal when their bits are.
struct Entry {
  std::uint64_t xy = 0, z_index = 0;

  Entry(const glm::vec3& p, std::uint32_t index)
      : xy(join(std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y))),
        z_index(join(std::bit_cast<std::uint32_t>(p.z), index)) {}
  std::uint32_t index() const { return static_cast<std::uint32_t>(z_index); }
  bool samePlace(const Entry& o) const { return xy == o.xy && z_index >> 32U == o.z_index >> 32U; }
  bool operator<(const Entry& o) const { return xy != o.xy ? xy < o.xy : z_index < o.z_index; }

 private:
  static std::uint64_t join(std::uint64_t high, std::uint64_t low) { return high << 32U | low; }
};

/// For each position the first one equal to it, or kNotFinite.
std::vector<std::uint32_t> firstEqual(const std::vector<glm::vec3>& positions) {
  std::vector<Entry> sorted;
  sorted.reserve(positions.size());
  std::vector<std::uint32_t> first(positions.size(), kNotFinite);
  for (std::uint32_t i = 0; i < positions.size(); ++i) {
    if (finite(positions[i])) sorted.emplace_back(positions[i], i);
  }
  std::sort(sorted.begin(), sorted.end());
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const bool same = i > 0 && sorted[i].samePlace(sorted[i - 1]);
    first[sorted[i].index()] = same ? first[sorted[i - 1].index()] : sorted[i].index();
  }
  return first;
}

/// Copies triangles into the mesh one surface after the other, numbering vertices as they come.
class Welder {
 public:
  Welder(Mesh& mesh, const std::vector<RawSurface>& surfaces)
      : mesh_(mesh), positions_(gatherPositions(surfaces)), first_(firstEqual(positions_)) {
    new_index_.assign(positions_.size(), kNotFinite);
    std::size_t triangles = 0;
    for (const RawSurface& s : surfaces) triangles += s.indices.size() / 3;
    mesh_.triangles.reserve(triangles);
  }

  void add(const RawSurface& surface) {
    const std::size_t before = mesh_.triangles.size();
    for (std::size_t t = 0; t + 2 < surface.indices.size(); t += 3)
      addTriangle(&surface.indices[t]);
    offset_ += static_cast<std::uint32_t>(surface.positions.size());
    noteSurface(surface, before);
  }

  /// Non-finite vertices that some triangle uses, each counted once.
  std::uint32_t nonFiniteUsed() const { return non_finite_used_; }

 private:
  void addTriangle(const std::uint32_t* indices) {
    std::array<std::uint32_t, 3> corner{};
    bool whole = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t given = offset_ + indices[k];
      corner[k] = first_[given];
      if (corner[k] == kNotFinite) {
        whole = false;
        noteNonFinite(given);
      }
    }
    whole = whole && corner[0] != corner[1] && corner[1] != corner[2] && corner[2] != corner[0];
    if (!whole) {
      ++mesh_.dropped_triangles;
      return;
    }
    for (std::uint32_t& c : corner) c = numbered(c);
    mesh_.triangles.push_back(corner);
  }

  void noteNonFinite(std::uint32_t given) {
    if (new_index_[given] == kNotFinite) ++non_finite_used_;
    new_index_[given] = 0;
  }

  std::uint32_t numbered(std::uint32_t first) {
    if (new_index_[first] == kNotFinite) {
      new_index_[first] = static_cast<std::uint32_t>(mesh_.positions.size());
      mesh_.positions.push_back(positions_[first]);
    }
    return new_index_[first];
  }

  void noteSurface(const RawSurface& raw, std::size_t before) {
    const auto count = static_cast<std::uint32_t>(mesh_.triangles.size() - before);
    if (count == 0) return;
    if (!mesh_.surfaces.empty()) {
      Surface& last = mesh_.surfaces.back();
      if (last.blocks == raw.blocks && last.double_sided == raw.double_sided) {
        last.triangle_count += count;
        return;
      }
    }
    mesh_.surfaces.push_back(
        {static_cast<std::uint32_t>(before), count, raw.blocks, raw.double_sided});
  }

  Mesh& mesh_;
  std::vector<glm::vec3> positions_;
  std::vector<std::uint32_t> first_;      // for each given vertex
  std::vector<std::uint32_t> new_index_;  // for each first vertex: its number in the mesh
  std::uint32_t offset_ = 0;
  std::uint32_t non_finite_used_ = 0;
};

/// A half-edge filed under its lower vertex.
struct FiledEdge {
  std::uint32_t higher_vertex;
  std::uint32_t half_edge;
};

/// Pairs half-edges of the same undirected edge that run in opposite directions.
class EdgePairing {
 public:
  explicit EdgePairing(Mesh& mesh) : mesh_(mesh), kind_of_(mesh.triangles.size()) {
    for (const Surface& s : mesh.surfaces) {
      const auto kind = static_cast<std::uint8_t>((s.blocks ? 1 : 0) + (s.double_sided ? 2 : 0));
      std::fill_n(kind_of_.begin() + s.first_triangle, s.triangle_count, kind);
    }
  }

  void run() {
    mesh_.partners.assign(mesh_.triangles.size() * 3, kOpenEdge);
    fileEdges();
    for (std::size_t v = 0; v + 1 < start_.size(); ++v) {
      pairAround(std::span(filed_).subspan(start_[v], start_[v + 1] - start_[v]));
    }
  }

 private:
  std::uint32_t from(std::uint32_t h) const { return mesh_.triangles[h / 3][h % 3]; }
  std::uint32_t to(std::uint32_t h) const { return mesh_.triangles[h / 3][(h % 3 + 1) % 3]; }

  void fileEdges() {
    const auto half_edges = static_cast<std::uint32_t>(mesh_.triangles.size() * 3);
    start_.assign(mesh_.positions.size() + 1, 0);
    for (std::uint32_t h = 0; h < half_edges; ++h) ++start_[std::min(from(h), to(h)) + 1];
    for (std::size_t v = 1; v < start_.size(); ++v) start_[v] += start_[v - 1];
    std::vector<std::uint32_t> next(start_.begin(), start_.end() - 1);
    filed_.resize(half_edges);
    for (std::uint32_t h = 0; h < half_edges; ++h) {
      filed_[next[std::min(from(h), to(h))]++] = {std::max(from(h), to(h)), h};
    }
  }

  void pairAround(std::span<FiledEdge> edges) {
    std::sort(edges.begin(), edges.end(), [](const FiledEdge& a, const FiledEdge& b) {
      return a.higher_vertex != b.higher_vertex ? a.higher_vertex < b.higher_vertex
                                                : a.half_edge < b.half_edge;
    });
    for (std::size_t i = 0; i < edges.size();) {
      std::size_t end = i + 1;
      while (end < edges.size() && edges[end].higher_vertex == edges[i].higher_vertex) ++end;
      pairMeeting(edges.subspan(i, end - i));
      i = end;
    }
  }

  /// Alike surfaces first: a wall's edge should meet the wall, not the glass that touches it.
  void pairMeeting(std::span<const FiledEdge> edges) {
    if (edges.size() < 2) return;
    for (std::uint8_t kind = 0; edges.size() > 2 && kind < kAnyKind; ++kind) pairAlike(edges, kind);
    pairAlike(edges, kAnyKind);
  }

  static constexpr std::uint8_t kAnyKind = 4;

  /// The k-th open half-edge that runs up meets the k-th that runs down.
  void pairAlike(std::span<const FiledEdge> edges, std::uint8_t kind) {
    const auto open = [&](const FiledEdge& e, bool upwards) {
      const std::uint32_t h = e.half_edge;
      return mesh_.partners[h] == kOpenEdge && (kind == kAnyKind || kind_of_[h / 3] == kind) &&
             (from(h) < to(h)) == upwards;
    };
    std::size_t up = 0, down = 0;
    for (;;) {
      while (up < edges.size() && !open(edges[up], true)) ++up;
      while (down < edges.size() && !open(edges[down], false)) ++down;
      if (up == edges.size() || down == edges.size()) return;
      mesh_.partners[edges[up].half_edge] = edges[down].half_edge;
      mesh_.partners[edges[down].half_edge] = edges[up].half_edge;
    }
  }

  Mesh& mesh_;
  std::vector<std::uint8_t> kind_of_;
  std::vector<std::uint32_t> start_;  // CSR over lower vertices
  std::vector<FiledEdge> filed_;
};

}  // namespace

std::size_t Mesh::bytes() const noexcept {
  return sizeof(Mesh) + positions.capacity() * sizeof(positions[0]) +
         triangles.capacity() * sizeof(triangles[0]) + partners.capacity() * sizeof(partners[0]) +
         surfaces.capacity() * sizeof(surfaces[0]);
}

Mesh makeMesh(const std::vector<RawSurface>& surfaces) {
  Mesh mesh;
  {
    Welder welder(mesh, surfaces);
    for (const RawSurface& s : surfaces) welder.add(s);
    mesh.non_finite_vertices = welder.nonFiniteUsed();
  }
  mesh.unbounded = mesh.non_finite_vertices > 0;
  for (const Surface& s : mesh.surfaces) mesh.blocking_triangles += s.blocks ? s.triangle_count : 0;
  EdgePairing(mesh).run();
  for (const glm::vec3& p : mesh.positions) mesh.bounds.grow(glm::dvec3(p));
  mesh.positions.shrink_to_fit();
  mesh.triangles.shrink_to_fit();
  mesh.surfaces.shrink_to_fit();
  return mesh;
}

}  // namespace culld
