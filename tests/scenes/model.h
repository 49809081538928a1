// A generated scene before it is a file or a snapshot: materials, meshes, a hierarchy of nodes.
// The same model gives both, so what is tested in memory is what a user can load.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "culling/scene/scene_snapshot.h"

namespace culld::scenes {

enum class Alpha : std::uint8_t { kOpaque, kMask, kBlend };

struct Material {
  std::string name;
  std::array<float, 4> color{0.8F, 0.8F, 0.8F, 1.0F};
  Alpha alpha = Alpha::kOpaque;
  bool double_sided = false;
};

/// Triangles, counter-clockwise seen from the front.
struct Triangles {
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> indices;
};

struct Part {
  Triangles triangles;
  std::uint32_t material = 0;
};

struct ModelMesh {
  std::string name;
  std::vector<Part> parts;
};

/// Rows of an affine map, as in Instance.
using Rows = std::array<double, 12>;
inline constexpr Rows kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

inline constexpr std::uint32_t kNone = 0xFFFFFFFFU;

struct ModelNode {
  std::uint32_t parent = kNone;  ///< an earlier node, or none
  std::uint32_t mesh = kNone;    ///< none: a group
  Rows parent_from_node = kIdentity;
  std::string name;  ///< may be empty
};

struct Model {
  std::vector<Material> materials;
  std::vector<ModelMesh> meshes;
  std::vector<ModelNode> nodes;

  std::uint32_t addMaterial(Material material);
  std::uint32_t addMesh(ModelMesh mesh);
  std::uint32_t addNode(ModelNode node);
  /// Nodes with a mesh.
  std::size_t objectCount() const;
};

Rows movedBy(const glm::dvec3& offset);
/// Turned about +y (counter-clockwise seen from above), then moved.
Rows turnedAndMoved(double angle_rad, const glm::dvec3& offset);
Rows scaledAndMoved(const glm::dvec3& scale, const glm::dvec3& offset);
/// First `inner`, then `outer`.
Rows composed(const Rows& outer, const Rows& inner);
/// Does it turn the fronts of triangles? By the sign of the determinant as doubles give it.
bool mirrors(const Rows& rows);

/// Objects are the nodes with a mesh, in node order; Instance::node is the node's index.
SnapshotPtr toSnapshot(const Model& model);

/// A .glb with the same nodes, meshes and numbers; equal models give equal bytes.
std::vector<std::byte> toGlb(const Model& model);

}  // namespace culld::scenes
