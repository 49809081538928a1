#include "culling/scene/gltf_meshes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "culling/scene/gltf_draco.h"
#include "culling/scene/scene_builder.h"

namespace culld::gltf {
namespace {

/// makeMesh numbers vertices and half-edges with 32 bits.
constexpr std::uint64_t kMaxPerMesh = 0xFFFFFFF0U;
/// Room that welding and pairing take for a while, per vertex and per index.
constexpr std::uint64_t kWorkBytesPerVertex = 32;
constexpr std::uint64_t kWorkBytesPerIndex = 32;

using Indices = std::vector<std::uint32_t>;

bool isTriangles(Mode mode) { return mode >= Mode::kTriangles; }

/// The vertices in drawing order: `indices`, or 0, 1, 2, ...
Indices readIndices(const DataSource& data, const Primitive& primitive, std::uint64_t vertices,
                    const Place& place, Budget& budget) {
  if (primitive.indices == kNone) {
    if (vertices > kMaxPerMesh) fail(place, std::to_string(vertices) + " vertices");
    budget.takeBytes(vertices * (sizeof(std::uint32_t) + kWorkBytesPerIndex));
    Indices all(vertices);
    std::iota(all.begin(), all.end(), 0U);
    return all;
  }
  const ElementReader reader(data, primitive.indices, budget);
  const Component type = reader.component();
  const bool whole =
      type == Component::kUint8 || type == Component::kUint16 || type == Component::kUint32;
  if (!whole || reader.width() != 1 || reader.normalized()) {
    fail(place, "accessor " + std::to_string(primitive.indices) + " holds no indices");
  }
  if (reader.count() > kMaxPerMesh) fail(place, std::to_string(reader.count()) + " indices");
  budget.takeBytes(reader.count() * (sizeof(std::uint32_t) + kWorkBytesPerIndex));
  Indices indices(reader.count());
  std::uint32_t largest = 0;
  for (std::size_t i = 0; i < indices.size(); ++i) {
    indices[i] = reader.unsignedAt(i);
    largest = std::max(largest, indices[i]);
  }
  if (largest >= vertices) {
    const auto bad = std::find_if(indices.begin(), indices.end(),
                                  [&](std::uint32_t index) { return index >= vertices; });
    fail(place, "index " + std::to_string(*bad) + " >= " + std::to_string(vertices) + " vertices");
  }
  return indices;
}

/// Strips repeat vertices to jump; such triangles have no area and are left out.
void addUnlessDegenerate(Indices& out, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  if (a == b || b == c || c == a) return;
  out.insert(out.end(), {a, b, c});
}

/// Lists of three, wound as glTF 2.0 section 3.7.2.1 says. Corners left over at the end are
/// ignored.
Indices toTriangleList(Indices drawn, Mode mode) {
  if (mode == Mode::kTriangles) {
    drawn.resize(drawn.size() - drawn.size() % 3);
    return drawn;
  }
  Indices list;
  if (drawn.size() < 3) return list;
  list.reserve(3 * (drawn.size() - 2));
  for (std::size_t i = 0; i + 2 < drawn.size(); ++i) {
    if (mode == Mode::kTriangleFan) {
      addUnlessDegenerate(list, drawn[i + 1], drawn[i + 2], drawn[0]);
    } else {
      addUnlessDegenerate(list, drawn[i], drawn[i + 1 + i % 2], drawn[i + 2 - i % 2]);
    }
  }
  return list;
}

ElementReader openPositions(const DataSource& data, const Primitive& primitive, const Place& place,
                            Budget& budget) {
  ElementReader reader(data, primitive.positions, budget);
  if (reader.width() != 3 || reader.component() == Component::kUint32) {
    fail(place, "accessor " + std::to_string(primitive.positions) + " holds no positions");
  }
  return reader;
}

/// Copies vertices once each, or, where many primitives share one large accessor, only those drawn.
void readVertices(const ElementReader& reader, Indices triangles, Budget& budget,
                  RawSurface& surface) {
  const std::uint64_t count = std::min<std::uint64_t>(reader.count(), triangles.size());
  budget.takeVertices(count);
  budget.takeBytes(count * (sizeof(glm::vec3) + kWorkBytesPerVertex));
  surface.positions.reserve(count);
  if (triangles.size() < reader.count()) {
    for (std::uint32_t& index : triangles) {
      surface.positions.push_back(reader.vec3At(index));
      index = static_cast<std::uint32_t>(surface.positions.size() - 1);
    }
  } else {
    for (std::uint64_t i = 0; i < count; ++i) surface.positions.push_back(reader.vec3At(i));
  }
  surface.indices = std::move(triangles);
}

/// Points and lines: they can be seen, so they count for the bounds, and they hide nothing.
struct Thin {
  Box bounds;
  std::uint64_t count = 0;
  std::uint64_t non_finite = 0;
};

std::uint64_t thinCount(Mode mode, std::uint64_t vertices) {
  if (mode == Mode::kPoints) return vertices;
  if (mode == Mode::kLines) return vertices / 2;
  if (vertices < 2) return 0;
  return mode == Mode::kLineLoop ? vertices : vertices - 1;
}

void addThin(const ElementReader& reader, const Indices& drawn, Mode mode, Thin& thin) {
  thin.count += thinCount(mode, drawn.size());
  for (const std::uint32_t index : drawn) {
    const glm::vec3 p = reader.vec3At(index);
    if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) {
      thin.bounds.grow(glm::dvec3(p));
    } else {
      ++thin.non_finite;
    }
  }
}

void decodeCompressed(const DataSource& data, const Primitive& primitive, const Place& place,
                      Budget& budget, RawSurface& surface) {
  if (!isTriangles(primitive.mode)) fail(place, "Draco for points or lines");
  if (primitive.draco->position_id == kNone) fail(place, "Draco without POSITION");
  const DracoPositions wanted{primitive.draco->position_id,
                              data.document().accessors[primitive.positions].normalized};
  decodeDraco(data.stored(primitive.draco->view, place), wanted, place, budget, surface);
}

std::uint32_t saturated(std::uint64_t n) {
  return static_cast<std::uint32_t>(
      std::min<std::uint64_t>(n, std::numeric_limits<std::uint32_t>::max()));
}

void checkSize(const std::vector<RawSurface>& surfaces, const Place& place) {
  std::uint64_t vertices = 0;
  std::uint64_t indices = 0;
  for (const RawSurface& surface : surfaces) {
    vertices += surface.positions.size();
    indices += surface.indices.size();
  }
  if (vertices > kMaxPerMesh || indices > kMaxPerMesh) {
    fail(ErrorCode::kLimit,
         place.text() + ": more than " + std::to_string(kMaxPerMesh) + " vertices or indices");
  }
}

void addThinTo(Mesh& mesh, const Thin& thin) {
  mesh.bounds.grow(thin.bounds);
  mesh.points_and_lines = saturated(thin.count);
  mesh.non_finite_vertices = saturated(mesh.non_finite_vertices + thin.non_finite);
  if (thin.non_finite > 0) mesh.unbounded = true;
}

}  // namespace

std::vector<std::uint32_t> accessorsOf(const MeshEntry& mesh) {
  std::vector<std::uint32_t> used;
  for (const Primitive& primitive : mesh.primitives) {
    if (primitive.positions == kNone || primitive.draco) continue;
    used.push_back(primitive.positions);
    if (primitive.indices != kNone) used.push_back(primitive.indices);
  }
  return used;
}

Mesh decodeMesh(const DataSource& data, std::uint32_t index, Budget& budget) {
  const MeshEntry& entry = data.document().meshes[index];
  std::vector<RawSurface> surfaces;
  Thin thin;
  bool morphed = false;
  for (std::size_t p = 0; p < entry.primitives.size(); ++p) {
    const Primitive& primitive = entry.primitives[p];
    if (primitive.positions == kNone) continue;  // nothing to draw
    const Place place =
        entry.primitives.size() == 1 ? Place{"mesh", index} : Place{"mesh", index, "primitive", p};
    morphed = morphed || primitive.morphed;
    RawSurface surface;
    surface.blocks = primitive.material.blocks;
    surface.double_sided = primitive.material.double_sided;
    if (primitive.draco) {
      decodeCompressed(data, primitive, place, budget, surface);
    } else {
      const ElementReader reader = openPositions(data, primitive, place, budget);
      Indices drawn = readIndices(data, primitive, reader.count(), place, budget);
      if (!isTriangles(primitive.mode)) {
        addThin(reader, drawn, primitive.mode, thin);
        continue;
      }
      readVertices(reader, toTriangleList(std::move(drawn), primitive.mode), budget, surface);
    }
    surfaces.push_back(std::move(surface));
  }
  checkSize(surfaces, {"mesh", index});
  Mesh mesh = makeMesh(surfaces);
  addThinTo(mesh, thin);
  mesh.unbounded = mesh.unbounded || morphed;
  return mesh;
}

}  // namespace culld::gltf
