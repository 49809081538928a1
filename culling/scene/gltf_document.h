// What culld needs of a glTF file, as plain structs: every index is in range, every number checked.
// Names, textures, images, cameras and lights are not read.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "culling/scene/gltf_json.h"

namespace culld::gltf {

/// glTF's codes for the type of a number in a buffer.
enum class Component : std::uint16_t {
  kInt8 = 5120,
  kUint8 = 5121,
  kInt16 = 5122,
  kUint16 = 5123,
  kUint32 = 5125,
  kFloat = 5126,
};
std::size_t bytesOf(Component component) noexcept;

struct Buffer {
  std::uint64_t byte_length = 0;
  std::string uri;
  bool has_uri = false;
  bool fallback = false;  ///< EXT_meshopt_compression: its bytes need not exist
};

enum class MeshoptMode : std::uint8_t { kAttributes, kTriangles, kIndices };
enum class MeshoptFilter : std::uint8_t { kPlain, kOctahedral, kQuaternion, kExponential };

struct MeshoptView {
  std::uint32_t buffer = kNone;
  std::uint64_t offset = 0, length = 0;
  std::uint64_t count = 0;
  std::uint32_t stride = 0;
  MeshoptMode mode = MeshoptMode::kAttributes;
  MeshoptFilter filter = MeshoptFilter::kPlain;
};

struct BufferView {
  std::uint32_t buffer = kNone;
  std::uint64_t offset = 0, length = 0;
  std::uint32_t stride = 0;  ///< 0: packed
  std::optional<MeshoptView> meshopt;
};

struct SparsePart {
  std::uint64_t count = 0;
  std::uint32_t indices_view = kNone, values_view = kNone;
  std::uint64_t indices_offset = 0, values_offset = 0;
  Component indices_component = Component::kUint32;
};

struct Accessor {
  std::uint32_t view = kNone;  ///< kNone: all zero
  std::uint64_t offset = 0;
  std::uint64_t count = 0;
  Component component = Component::kFloat;
  std::uint8_t width = 1;  ///< numbers per element; 0: of an unknown type
  bool normalized = false;
  std::optional<SparsePart> sparse;
};

struct Material {
  bool blocks = true;
  bool double_sided = false;
};

enum class Mode : std::uint8_t {
  kPoints,
  kLines,
  kLineLoop,
  kLineStrip,
  kTriangles,
  kTriangleStrip,
  kTriangleFan
};

struct DracoLink {
  std::uint32_t view = kNone;
  std::uint32_t position_id = kNone;
};

struct Primitive {
  Mode mode = Mode::kTriangles;
  std::uint32_t positions = kNone;  ///< kNone: nothing to draw
  std::uint32_t indices = kNone;
  Material material;
  std::optional<DracoLink> draco;
  bool morphed = false;
};

struct MeshEntry {
  std::vector<Primitive> primitives;
};

/// EXT_mesh_gpu_instancing: accessors, or kNone.
struct Instancing {
  std::uint32_t translation = kNone, rotation = kNone, scale = kNone;
  std::uint64_t count = 0;
};

/// Rows of an affine map in double, as Instance::world_from_mesh.
using Affine = std::array<double, 12>;

struct Node {
  Affine parent_from_node{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  std::uint32_t mesh = kNone;
  std::uint32_t first_child = 0, child_count = 0;  ///< in Document::children
  std::uint32_t instancing = kNone;                ///< in Document::instancings
  /// Skinned, animated, switched off or with other levels of detail: what a viewer shows may differ
  /// from the file at rest, here and in all children.
  bool restless = false;
};

struct Document {
  std::vector<Buffer> buffers;
  std::vector<BufferView> views;
  std::vector<Accessor> accessors;
  std::vector<Material> materials;
  std::vector<MeshEntry> meshes;
  std::vector<Node> nodes;
  std::vector<std::uint32_t> children;
  std::vector<Instancing> instancings;
  std::vector<std::uint32_t> roots;  ///< of the default scene
};

/// Throws LoadFailure naming the place.
Document readDocument(const JsonView& root);

/// Rows of translation * rotation * scale. The quaternion (x, y, z, w) is used as it is: what is
/// not of unit length shears, as it does in renderers that follow the formula.
Affine composeTrs(const std::array<double, 3>& translation, const std::array<double, 4>& rotation,
                  const std::array<double, 3>& scale);
Affine multiply(const Affine& a, const Affine& b);

// The parts of readDocument, each in a file of its own.
void readData(const JsonView& root, Document& document);    // gltf_document_data.cpp
void readMeshes(const JsonView& root, Document& document);  // gltf_document_meshes.cpp
void readNodes(const JsonView& root, Document& document);   // gltf_document_nodes.cpp

}  // namespace culld::gltf
