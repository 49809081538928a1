// Buffers, buffer views and accessors: the layer that says where bytes lie.
#include <limits>

#include "culling/scene/gltf_document.h"

namespace culld::gltf {
namespace {

constexpr const char* kMeshopt = "EXT_meshopt_compression";
constexpr std::uint64_t kMaxStride = 256;

JsonView listOf(const JsonView& root, const char* key) {
  const JsonView list = root[key];
  if (list && !list.isArray()) fail(key, "is not an array");
  return list;
}

JsonView objectAt(const JsonView& list, std::size_t i, const Place& place) {
  const JsonView item = list.at(i);
  if (!item.isObject()) fail(place, "is not an object");
  return item;
}

JsonView extensionOf(const JsonView& item, const Place& place, const char* name) {
  return item.object(place, "extensions").object(place, name);
}

void checkRange(const Place& place, std::uint64_t offset, std::uint64_t length,
                const Document& document, std::uint32_t buffer) {
  const std::uint64_t size = document.buffers[buffer].byte_length;
  if (offset > size || length > size - offset) {
    fail(place, "bytes " + std::to_string(offset) + " + " + std::to_string(length) + " > " +
                    std::to_string(size) + " of buffer " + std::to_string(buffer));
  }
}

Buffer readBuffer(const JsonView& item, const Place& place) {
  Buffer buffer;
  buffer.byte_length = item.count(place, "byteLength");
  buffer.has_uri = static_cast<bool>(item["uri"]);
  buffer.uri = item.text(place, "uri");
  buffer.fallback = extensionOf(item, place, kMeshopt).flagOr(place, "fallback", false);
  return buffer;
}

std::uint32_t readStride(const JsonView& item, const Place& place) {
  const std::uint64_t stride = item.countOr(place, "byteStride", 0);
  if (stride > kMaxStride) fail(place, "byteStride " + std::to_string(stride) + " > 256");
  return static_cast<std::uint32_t>(stride);
}

MeshoptMode readMode(const JsonView& item, const Place& place) {
  const std::string mode = item.text(place, "mode");
  if (mode == "ATTRIBUTES") return MeshoptMode::kAttributes;
  if (mode == "TRIANGLES") return MeshoptMode::kTriangles;
  if (mode == "INDICES") return MeshoptMode::kIndices;
  fail(place, "unknown meshopt mode");
}

MeshoptFilter readFilter(const JsonView& item, const Place& place) {
  const std::string filter = item.text(place, "filter");
  if (filter.empty() || filter == "NONE") return MeshoptFilter::kPlain;
  if (filter == "OCTAHEDRAL") return MeshoptFilter::kOctahedral;
  if (filter == "QUATERNION") return MeshoptFilter::kQuaternion;
  if (filter == "EXPONENTIAL") return MeshoptFilter::kExponential;
  fail(place, "unknown meshopt filter");
}

void checkMeshoptShape(const MeshoptView& view, const Place& place) {
  const std::uint32_t stride = view.stride;
  if (view.mode == MeshoptMode::kAttributes) {
    if (stride == 0 || stride % 4 != 0) fail(place, "meshopt attributes need a byteStride of 4 n");
  } else if (stride != 2 && stride != 4) {
    fail(place, "meshopt indices need a byteStride of 2 or 4");
  }
  if (view.mode == MeshoptMode::kTriangles && view.count % 3 != 0) {
    fail(place, "meshopt triangles need a count of 3 n");
  }
  const bool octahedral_fits = stride == 4 || stride == 8;
  if ((view.filter == MeshoptFilter::kOctahedral && !octahedral_fits) ||
      (view.filter == MeshoptFilter::kQuaternion && stride != 8) ||
      (view.filter != MeshoptFilter::kPlain && view.mode != MeshoptMode::kAttributes)) {
    fail(place, "the meshopt filter does not fit mode and byteStride");
  }
}

std::optional<MeshoptView> readMeshopt(const JsonView& item, const Place& place,
                                       const Document& document) {
  const JsonView extension = extensionOf(item, place, kMeshopt);
  if (!extension) return std::nullopt;
  MeshoptView view;
  view.buffer = extension.index(place, "buffer", document.buffers.size(), "buffers");
  if (view.buffer == kNone) fail(place, "the meshopt buffer is missing");
  view.offset = extension.countOr(place, "byteOffset", 0);
  view.length = extension.count(place, "byteLength");
  view.stride = readStride(extension, place);
  view.count = extension.count(place, "count");
  view.mode = readMode(extension, place);
  view.filter = readFilter(extension, place);
  checkRange(place, view.offset, view.length, document, view.buffer);
  checkMeshoptShape(view, place);
  return view;
}

BufferView readView(const JsonView& item, const Place& place, const Document& document) {
  BufferView view;
  view.buffer = item.index(place, "buffer", document.buffers.size(), "buffers");
  if (view.buffer == kNone) fail(place, "buffer is missing");
  view.offset = item.countOr(place, "byteOffset", 0);
  view.length = item.count(place, "byteLength");
  view.stride = readStride(item, place);
  view.meshopt = readMeshopt(item, place, document);
  checkRange(place, view.offset, view.length, document, view.buffer);
  return view;
}

Component readComponent(const JsonView& item, const Place& place) {
  const std::uint64_t code = item.count(place, "componentType");
  switch (code) {
    case 5120:
      return Component::kInt8;
    case 5121:
      return Component::kUint8;
    case 5122:
      return Component::kInt16;
    case 5123:
      return Component::kUint16;
    case 5125:
      return Component::kUint32;
    case 5126:
      return Component::kFloat;
    default:
      fail(place, "unknown componentType " + std::to_string(code));
  }
}

std::uint8_t readWidth(const JsonView& item, const Place& place) {
  const std::string type = item.text(place, "type");
  if (type == "SCALAR") return 1;
  if (type == "VEC2") return 2;
  if (type == "VEC3") return 3;
  if (type == "VEC4" || type == "MAT2") return 4;
  if (type == "MAT3") return 9;
  if (type == "MAT4") return 16;
  return 0;  // harmless unless something reads it
}

std::optional<SparsePart> readSparse(const JsonView& item, const Place& place,
                                     const Document& document, std::uint64_t elements) {
  const JsonView sparse = item.object(place, "sparse");
  if (!sparse) return std::nullopt;
  const JsonView indices = sparse.object(place, "indices");
  const JsonView values = sparse.object(place, "values");
  SparsePart part;
  part.count = sparse.count(place, "count");
  if (part.count > elements) {
    fail(place, std::to_string(part.count) + " sparse elements > " + std::to_string(elements));
  }
  part.indices_view = indices.index(place, "bufferView", document.views.size(), "bufferViews");
  part.values_view = values.index(place, "bufferView", document.views.size(), "bufferViews");
  if (part.indices_view == kNone || part.values_view == kNone) {
    fail(place, "sparse without indices or values");
  }
  part.indices_offset = indices.countOr(place, "byteOffset", 0);
  part.values_offset = values.countOr(place, "byteOffset", 0);
  part.indices_component = readComponent(indices, place);
  return part;
}

Accessor readAccessor(const JsonView& item, const Place& place, const Document& document) {
  Accessor accessor;
  accessor.view = item.index(place, "bufferView", document.views.size(), "bufferViews");
  accessor.offset = item.countOr(place, "byteOffset", 0);
  accessor.count = item.count(place, "count");
  if (accessor.count == 0) fail(place, "count is 0");
  accessor.component = readComponent(item, place);
  accessor.width = readWidth(item, place);
  accessor.normalized = item.flagOr(place, "normalized", false);
  accessor.sparse = readSparse(item, place, document, accessor.count);
  return accessor;
}

}  // namespace

void readData(const JsonView& root, Document& document) {
  const JsonView buffers = listOf(root, "buffers");
  for (std::size_t i = 0; i < buffers.size(); ++i) {
    const Place place{"buffer", i};
    document.buffers.push_back(readBuffer(objectAt(buffers, i, place), place));
  }
  const JsonView views = listOf(root, "bufferViews");
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Place place{"bufferView", i};
    document.views.push_back(readView(objectAt(views, i, place), place, document));
  }
  const JsonView accessors = listOf(root, "accessors");
  for (std::size_t i = 0; i < accessors.size(); ++i) {
    const Place place{"accessor", i};
    document.accessors.push_back(readAccessor(objectAt(accessors, i, place), place, document));
  }
}

}  // namespace culld::gltf
