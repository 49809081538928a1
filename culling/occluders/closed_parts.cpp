#include "culling/occluders/closed_parts.h"

#include <algorithm>
#include <glm/geometric.hpp>
#include <utility>

namespace culld {
namespace {

class PartFinder {
 public:
  PartFinder(const Mesh& mesh, std::size_t most_triangles)
      : mesh_(mesh), most_triangles_(most_triangles), kind_(mesh.triangles.size(), kSeeThrough) {
    for (const Surface& s : mesh.surfaces) {
      if (!s.blocks) continue;
      std::fill_n(kind_.begin() + s.first_triangle, s.triangle_count,
                  s.double_sided ? kTwoSided : kOneSided);
    }
    found_.resize(kind_.size(), false);
  }

  std::vector<ClosedPart> run() {
    std::vector<ClosedPart> parts;
    for (std::uint32_t t = 0; t < kind_.size(); ++t) {
      if (kind_[t] == kSeeThrough || found_[t]) continue;
      ClosedPart part;
      if (!takeFrom(t, part) || part.triangles.size() > most_triangles_) continue;
      part.box_mesh = boxOfTriangles(mesh_, part.triangles);
      parts.push_back(std::move(part));
    }
    return parts;
  }

 private:
  enum Kind : std::uint8_t { kSeeThrough, kOneSided, kTwoSided };

  /// All that is connected with `first`. False: it is open.
  bool takeFrom(std::uint32_t first, ClosedPart& part) {
    bool closed = true;
    part.triangles.push_back(first);
    found_[first] = true;
    for (std::size_t i = 0; i < part.triangles.size(); ++i) {
      const std::uint32_t t = part.triangles[i];
      part.two_sided = part.two_sided && kind_[t] == kTwoSided;
      for (std::uint32_t e = 0; e < 3; ++e) {
        const std::uint32_t partner = mesh_.partners[3 * t + e];
        if (partner == kOpenEdge || kind_[partner / 3] == kSeeThrough) {
          closed = false;
        } else if (!found_[partner / 3]) {
          found_[partner / 3] = true;
          part.triangles.push_back(partner / 3);
        }
      }
    }
    return closed;
  }

  const Mesh& mesh_;
  std::size_t most_triangles_;
  std::vector<Kind> kind_;
  std::vector<bool> found_;
};

}  // namespace

Box boxOfTriangles(const Mesh& mesh, std::span<const std::uint32_t> triangles) {
  Box box;
  for (const std::uint32_t t : triangles) {
    for (const std::uint32_t v : mesh.triangles[t]) box.grow(glm::dvec3(mesh.positions[v]));
  }
  return box;
}

std::vector<ClosedPart> closedParts(const Mesh& mesh, std::size_t most_triangles,
                                    std::size_t most_parts) {
  std::vector<ClosedPart> parts = PartFinder(mesh, most_triangles).run();
  const auto size = [](const ClosedPart& part) {
    return glm::length(part.box_mesh.max - part.box_mesh.min);
  };
  std::stable_sort(parts.begin(), parts.end(),
                   [&](const ClosedPart& a, const ClosedPart& b) { return size(a) > size(b); });
  if (parts.size() > most_parts) parts.resize(most_parts);
  return parts;
}

}  // namespace culld
