// Small glTF files made in memory: tests say the JSON that matters and append bytes for the rest.
#pragma once
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "culling/scene/gltf_loader.h"

namespace culld::test {

using Bytes = std::vector<std::byte>;

template <typename T>
void append(Bytes& bytes, const T& value) {
  const auto* from = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), from, from + sizeof value);
}

/// A GLB container around any JSON and binary chunk, both padded to four bytes.
inline Bytes glbOf(std::string json, Bytes binary) {
  while (json.size() % 4 != 0) json += ' ';
  while (binary.size() % 4 != 0) binary.push_back(std::byte{0});
  Bytes file;
  const std::size_t chunk = binary.empty() ? 0 : 8 + binary.size();
  append(file, std::uint32_t{0x46546C67});
  append(file, std::uint32_t{2});
  append(file, static_cast<std::uint32_t>(20 + json.size() + chunk));
  append(file, static_cast<std::uint32_t>(json.size()));
  append(file, std::uint32_t{0x4E4F534A});
  for (const char c : json) file.push_back(static_cast<std::byte>(c));
  if (binary.empty()) return file;
  append(file, static_cast<std::uint32_t>(binary.size()));
  append(file, std::uint32_t{0x004E4942});
  file.insert(file.end(), binary.begin(), binary.end());
  return file;
}

/// Collects bytes, views and accessors; meshes, nodes and the rest are written as JSON.
class GltfFile {
 public:
  /// Appends values to the binary chunk as a buffer view of their own. Returns the view.
  template <typename T>
  int view(const std::vector<T>& values, const std::string& more = "") {
    while (binary_.size() % 4 != 0) binary_.push_back(std::byte{0});
    const std::size_t begin = binary_.size();
    for (const T& value : values) append(binary_, value);
    return viewOf(begin, binary_.size() - begin, more);
  }
  int viewOf(std::size_t begin, std::size_t length, const std::string& more = "") {
    return rawView(R"({"buffer":0,"byteOffset":)" + std::to_string(begin) + R"(,"byteLength":)" +
                   std::to_string(length) + more + "}");
  }
  int rawView(const std::string& json) { return add(views_, json); }

  /// `view` < 0: none.
  int accessor(int view, int component, std::size_t count, const std::string& type,
               const std::string& more = "") {
    std::string json = "{";
    if (view >= 0) json += R"("bufferView":)" + std::to_string(view) + ",";
    json += R"("componentType":)" + std::to_string(component) + R"(,"count":)" +
            std::to_string(count) + R"(,"type":")" + type + "\"" + more + "}";
    return add(accessors_, json);
  }
  /// Three floats each.
  int positions(const std::vector<float>& xyz) {
    return accessor(view(xyz), 5126, xyz.size() / 3, "VEC3");
  }
  int indices(const std::vector<std::uint16_t>& values) {
    return accessor(view(values), 5123, values.size(), "SCALAR");
  }

  /// A mesh of one primitive; `more` continues its JSON: `,"mode":1`.
  int mesh(int positions, int indices = -1, const std::string& more = "") {
    return meshOf({primitive(positions, indices, more)});
  }
  static std::string primitive(int positions, int indices = -1, const std::string& more = "") {
    std::string json = R"({"attributes":{"POSITION":)" + std::to_string(positions) + "}";
    if (indices >= 0) json += R"(,"indices":)" + std::to_string(indices);
    return json + more + "}";
  }
  int meshOf(std::initializer_list<std::string> primitives) {
    std::string list;
    for (const std::string& p : primitives) list += (list.empty() ? "" : ",") + p;
    return add(meshes_, R"({"primitives":[)" + list + "]}");
  }
  int node(const std::string& json) { return add(nodes_, json); }
  int nodeWith(int mesh, const std::string& more = "") {
    return node(R"({"mesh":)" + std::to_string(mesh) + more + "}");
  }
  int material(const std::string& json) { return add(materials_, json); }
  /// A further member of the root: `"scene":1`.
  void top(const std::string& member) { top_ += "," + member; }
  /// Replaces the list of buffers, which is else the binary chunk alone.
  void buffers(const std::string& json) { buffers_ = json; }

  const Bytes& binary() const { return binary_; }
  std::string json() const {
    const std::string buffers =
        buffers_.empty() ? R"({"byteLength":)" + std::to_string(binary_.size()) + "}" : buffers_;
    return R"({"asset":{"version":"2.0"})" +
           member("buffers", binary_.empty() ? buffers_ : buffers) +
           member("bufferViews", views_.items) + member("accessors", accessors_.items) +
           member("materials", materials_.items) + member("meshes", meshes_.items) +
           member("nodes", nodes_.items) + top_ + "}";
  }
  Bytes glb() const { return glbOf(json(), binary_); }

 private:
  struct List {
    std::string items;
    int count = 0;
  };
  static int add(List& list, const std::string& json) {
    list.items += (list.count == 0 ? "" : ",") + json;
    return list.count++;
  }
  static std::string member(const std::string& key, const std::string& items) {
    return items.empty() ? "" : ",\"" + key + "\":[" + items + "]";
  }

  Bytes binary_;
  std::string buffers_, top_;
  List views_, accessors_, materials_, meshes_, nodes_;
};

/// A right triangle in the plane z = 0, counter-clockwise.
inline const std::vector<float> kTriangle = {0, 0, 0, 1, 0, 0, 0, 1, 0};
/// The unit square in the plane z = 0.
inline const std::vector<float> kSquare = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};

inline Result<SnapshotPtr> load(const Bytes& file, const LoadOptions& options = {}) {
  return loadGltfBytes(file, "t.glb", options);
}
/// The error line, or "" if it loads.
inline std::string errorOf(const Bytes& file, const LoadOptions& options = {}) {
  const Result<SnapshotPtr> scene = load(file, options);
  return scene.ok() ? "" : scene.error().message;
}
inline Bytes bytesOf(std::string_view text) {
  Bytes bytes;
  for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
  return bytes;
}

}  // namespace culld::test
