#include "tests/scenes/model.h"

#include <cmath>
#include <utility>

#include "culling/scene/scene_builder.h"

namespace culld::scenes {
namespace {

template <typename T>
std::uint32_t pushed(std::vector<T>& to, T value) {
  to.push_back(std::move(value));
  return static_cast<std::uint32_t>(to.size() - 1);
}

Mesh toMesh(const Model& model, const ModelMesh& mesh) {
  std::vector<RawSurface> surfaces;
  for (const Part& part : mesh.parts) {
    const Material& material = model.materials[part.material];
    surfaces.push_back({part.triangles.positions, part.triangles.indices,
                        material.alpha == Alpha::kOpaque, material.double_sided});
  }
  return makeMesh(surfaces);
}

}  // namespace

std::uint32_t Model::addMaterial(Material material) {
  return pushed(materials, std::move(material));
}
std::uint32_t Model::addMesh(ModelMesh mesh) { return pushed(meshes, std::move(mesh)); }
std::uint32_t Model::addNode(ModelNode node) { return pushed(nodes, std::move(node)); }

std::size_t Model::objectCount() const {
  std::size_t count = 0;
  for (const ModelNode& node : nodes) count += node.mesh != kNone ? 1 : 0;
  return count;
}

Rows movedBy(const glm::dvec3& o) { return {1, 0, 0, o.x, 0, 1, 0, o.y, 0, 0, 1, o.z}; }

Rows turnedAndMoved(double angle_rad, const glm::dvec3& o) {
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  return {c, 0, s, o.x, 0, 1, 0, o.y, -s, 0, c, o.z};
}

Rows scaledAndMoved(const glm::dvec3& s, const glm::dvec3& o) {
  return {s.x, 0, 0, o.x, 0, s.y, 0, o.y, 0, 0, s.z, o.z};
}

bool mirrors(const Rows& m) {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[1] * (m[4] * m[10] - m[6] * m[8]) +
             m[2] * (m[4] * m[9] - m[5] * m[8]) <
         0.0;
}

Rows composed(const Rows& outer, const Rows& inner) {
  Rows all{};
  for (std::size_t r = 0; r < 3; ++r) {
    const double* a = &outer[4 * r];
    for (std::size_t c = 0; c < 4; ++c) {
      all[4 * r + c] = a[0] * inner[c] + a[1] * inner[4 + c] + a[2] * inner[8 + c];
    }
    all[4 * r + 3] += a[3];
  }
  return all;
}

SnapshotPtr toSnapshot(const Model& model) {
  SceneBuilder builder;
  for (const ModelMesh& mesh : model.meshes) builder.addMesh(toMesh(model, mesh));
  std::vector<Rows> world(model.nodes.size());
  for (std::uint32_t n = 0; n < model.nodes.size(); ++n) {
    const ModelNode& node = model.nodes[n];
    world[n] = node.parent == kNone ? node.parent_from_node
                                    : composed(world[node.parent], node.parent_from_node);
    if (node.mesh != kNone) builder.addInstance(node.mesh, world[n], n);
  }
  return builder.finish();
}

}  // namespace culld::scenes
