// glTF 2.0 §4.4: header, one JSON chunk, one binary chunk. Three views share the one buffer.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "tests/scenes/model.h"

namespace culld::scenes {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kFloat = 5126, kUint16 = 5123, kUint32 = 5125;  // component types
constexpr int kArrayBuffer = 34962, kElementArrayBuffer = 34963;
enum View : std::size_t { kPositions, kShortIndices, kLongIndices, kViewCount };

/// Whole numbers without a fraction: shorter, and equal when read again. Minus zero stays one.
Json number(double value) {
  const bool whole = std::abs(value) < 9e15 && value == std::trunc(value);
  if (whole && !(value == 0.0 && std::signbit(value))) return static_cast<std::int64_t>(value);
  return value;
}

Json numbers(std::initializer_list<double> values) {
  Json list = Json::array();
  for (const double v : values) list.push_back(number(v));
  return list;
}

/// Only what differs from the identity; scale and translation by name where that says it all.
void writeTransform(Json& node, const Rows& m) {
  const bool axis_parallel =
      m[1] == 0.0 && m[2] == 0.0 && m[4] == 0.0 && m[6] == 0.0 && m[8] == 0.0 && m[9] == 0.0;
  if (!axis_parallel) {
    node["matrix"] = numbers(
        {m[0], m[4], m[8], 0, m[1], m[5], m[9], 0, m[2], m[6], m[10], 0, m[3], m[7], m[11], 1});
    return;
  }
  if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0) {
    node["translation"] = numbers({m[3], m[7], m[11]});
  }
  if (m[0] != 1.0 || m[5] != 1.0 || m[10] != 1.0) node["scale"] = numbers({m[0], m[5], m[10]});
}

class GlbWriter {
 public:
  explicit GlbWriter(const Model& model) : model_(model) {}

  std::vector<std::byte> write() {
    document_["asset"] = {{"version", "2.0"}, {"generator", "culld make_scene"}};
    document_["scene"] = 0;
    document_["scenes"] = Json::array({Json::object()});
    writeNodes();
    writeMaterials();
    writeMeshes();
    writeBuffer();
    return assemble();
  }

 private:
  void writeNodes() {
    std::vector<std::vector<std::uint32_t>> children(model_.nodes.size());
    std::vector<std::uint32_t> roots;
    for (std::uint32_t n = 0; n < model_.nodes.size(); ++n) {
      const std::uint32_t parent = model_.nodes[n].parent;
      (parent == kNone ? roots : children[parent]).push_back(n);
    }
    if (!roots.empty()) document_["scenes"][0]["nodes"] = roots;
    Json nodes = Json::array();
    for (std::uint32_t n = 0; n < model_.nodes.size(); ++n) {
      const ModelNode& from = model_.nodes[n];
      Json node = Json::object();
      if (!from.name.empty()) node["name"] = from.name;
      if (from.mesh != kNone) node["mesh"] = from.mesh;
      writeTransform(node, from.parent_from_node);
      if (!children[n].empty()) node["children"] = children[n];
      nodes.push_back(std::move(node));
    }
    if (!nodes.empty()) document_["nodes"] = std::move(nodes);
  }

  void writeMaterials() {
    for (const Material& from : model_.materials) {
      Json material = Json::object();
      if (!from.name.empty()) material["name"] = from.name;
      material["pbrMetallicRoughness"] = {
          {"baseColorFactor", from.color}, {"metallicFactor", 0}, {"roughnessFactor", 1}};
      if (from.alpha == Alpha::kMask) material["alphaMode"] = "MASK";
      if (from.alpha == Alpha::kBlend) material["alphaMode"] = "BLEND";
      if (from.double_sided) material["doubleSided"] = true;
      document_["materials"].push_back(std::move(material));
    }
  }

  void writeMeshes() {
    for (const ModelMesh& from : model_.meshes) {
      Json mesh = Json::object();
      if (!from.name.empty()) mesh["name"] = from.name;
      for (const Part& part : from.parts) {
        Json primitive = Json::object();
        primitive["attributes"] = {{"POSITION", addPositions(part.triangles)}};
        primitive["indices"] = addIndices(part.triangles);
        primitive["material"] = part.material;
        mesh["primitives"].push_back(std::move(primitive));
      }
      document_["meshes"].push_back(std::move(mesh));
    }
  }

  std::size_t addPositions(const Triangles& triangles) {
    glm::vec3 low(triangles.positions.front()), high(low);
    const std::size_t offset = bytes_[kPositions].size();
    for (const glm::vec3& p : triangles.positions) {
      low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
      high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
      for (int i = 0; i < 3; ++i) put(kPositions, p[i]);
    }
    Json accessor = accessorOf(kPositions, offset, kFloat, triangles.positions.size(), "VEC3");
    accessor["min"] = numbers({low.x, low.y, low.z});
    accessor["max"] = numbers({high.x, high.y, high.z});
    return addAccessor(std::move(accessor));
  }

  std::size_t addIndices(const Triangles& triangles) {
    const bool small = triangles.positions.size() < 0xFFFF;
    const View view = small ? kShortIndices : kLongIndices;
    const std::size_t offset = bytes_[view].size();
    for (const std::uint32_t i : triangles.indices) {
      small ? put(view, static_cast<std::uint16_t>(i)) : put(view, i);
    }
    return addAccessor(
        accessorOf(view, offset, small ? kUint16 : kUint32, triangles.indices.size(), "SCALAR"));
  }

  static Json accessorOf(View view, std::size_t offset, int type, std::size_t count,
                         const char* shape) {
    return {{"bufferView", view},
            {"byteOffset", offset},
            {"componentType", type},
            {"count", count},
            {"type", shape}};
  }

  std::size_t addAccessor(Json accessor) {
    document_["accessors"].push_back(std::move(accessor));
    return document_["accessors"].size() - 1;
  }

  template <typename T>
  void put(View view, T value) {
    const auto* raw = reinterpret_cast<const std::byte*>(&value);
    bytes_[view].insert(bytes_[view].end(), raw, raw + sizeof(T));
  }

  /// Views without bytes are left out, so the numbers in the accessors are mapped.
  void writeBuffer() {
    std::array<std::size_t, kViewCount> number_of{};
    for (std::size_t v = 0; v < kViewCount; ++v) {
      if (bytes_[v].empty()) continue;
      number_of[v] = document_["bufferViews"].size();
      Json view = {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", bytes_[v].size()}};
      if (v == kPositions) view["byteStride"] = 12;
      view["target"] = v == kPositions ? kArrayBuffer : kElementArrayBuffer;
      document_["bufferViews"].push_back(std::move(view));
      binary_.insert(binary_.end(), bytes_[v].begin(), bytes_[v].end());
      binary_.resize((binary_.size() + 3) / 4 * 4);
    }
    if (binary_.empty()) return;
    for (Json& accessor : document_["accessors"]) {
      accessor["bufferView"] = number_of[accessor["bufferView"].get<std::size_t>()];
    }
    Json buffer = Json::object();
    buffer["byteLength"] = binary_.size();
    document_["buffers"].push_back(std::move(buffer));
  }

  std::vector<std::byte> assemble() const {
    std::string json = document_.dump();
    json.resize((json.size() + 3) / 4 * 4, ' ');
    std::vector<std::byte> glb;
    const auto word = [&glb](std::size_t value) {
      const auto v = static_cast<std::uint32_t>(value);
      const auto* raw = reinterpret_cast<const std::byte*>(&v);
      glb.insert(glb.end(), raw, raw + 4);
    };
    const std::size_t binary_chunk = binary_.empty() ? 0 : 8 + binary_.size();
    word(0x46546C67);  // "glTF"
    word(2);
    word(12 + 8 + json.size() + binary_chunk);
    word(json.size());
    word(0x4E4F534A);  // "JSON"
    const auto* text = reinterpret_cast<const std::byte*>(json.data());
    glb.insert(glb.end(), text, text + json.size());
    if (binary_.empty()) return glb;
    word(binary_.size());
    word(0x004E4942);  // "BIN"
    glb.insert(glb.end(), binary_.begin(), binary_.end());
    return glb;
  }

  const Model& model_;
  Json document_ = Json::object();
  std::array<std::vector<std::byte>, kViewCount> bytes_;
  std::vector<std::byte> binary_;
};

}  // namespace

std::vector<std::byte> toGlb(const Model& model) { return GlbWriter(model).write(); }

}  // namespace culld::scenes
