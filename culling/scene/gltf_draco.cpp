#include "culling/scene/gltf_draco.h"

#include <draco/compression/decode.h>
#include <draco/core/varint_decoding.h>
#include <draco/metadata/metadata_decoder.h>

#include <algorithm>
#include <array>
#include <memory>
#include <string>

namespace culld::gltf {
namespace {

/// The extension fixes the bitstream to 2.2.
constexpr std::uint8_t kVersion[] = {2, 2};
constexpr std::uint16_t kMetadataFlag = 0x8000;
/// The decoder believes the header and allocates: hold that to what real meshes reach.
constexpr std::uint64_t kFacesPerByte = 1024;
constexpr std::uint64_t kFreeFaces = 65536;
/// Corner table, attribute corner tables and values while decoding.
constexpr std::uint64_t kBytesPerFace = 160;

struct DracoCounts {
  std::uint32_t faces = 0;
  std::uint32_t points = 0;
};

draco::DecoderBuffer bufferOf(std::span<const std::byte> stored) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(stored.data()), stored.size());
  buffer.set_bitstream_version(DRACO_BITSTREAM_VERSION(2, 2));
  return buffer;
}

/// What the header announces, read ahead of the decoder.
DracoCounts readCounts(std::span<const std::byte> stored, const Place& place) {
  draco::DecoderBuffer buffer = bufferOf(stored);
  std::array<char, 5> magic{};
  std::array<std::uint8_t, 4> head{};  // version major, minor, geometry, method
  std::uint16_t flags = 0;
  const bool whole = buffer.Decode(magic.data(), magic.size()) &&
                     buffer.Decode(head.data(), head.size()) && buffer.Decode(&flags);
  if (!whole || std::string(magic.data(), magic.size()) != "DRACO")
    fail(place, "not a Draco stream");
  if (head[0] != kVersion[0] || head[1] != kVersion[1]) {
    fail(place, "Draco bitstream " + std::to_string(head[0]) + "." + std::to_string(head[1]) +
                    " instead of 2.2");
  }
  if (head[2] != draco::TRIANGULAR_MESH) fail(place, "the Draco stream is not a triangle mesh");
  if ((flags & kMetadataFlag) != 0) {
    draco::GeometryMetadata metadata;
    if (!draco::MetadataDecoder().DecodeGeometryMetadata(&buffer, &metadata)) {
      fail(place, "the Draco stream is broken");
    }
  }
  DracoCounts counts;
  bool read = true;
  if (head[3] == draco::MESH_SEQUENTIAL_ENCODING) {
    read =
        draco::DecodeVarint(&counts.faces, &buffer) && draco::DecodeVarint(&counts.points, &buffer);
  } else {
    std::uint8_t traversal = 0;
    read = buffer.Decode(&traversal) && draco::DecodeVarint(&counts.points, &buffer) &&
           draco::DecodeVarint(&counts.faces, &buffer);
  }
  if (!read) fail(place, "the Draco stream is broken");
  return counts;
}

void checkCounts(const DracoCounts& counts, std::size_t stored, const Place& place,
                 Budget& budget) {
  const std::uint64_t most = kFreeFaces + kFacesPerByte * stored;
  if (counts.faces > most || counts.points > 3 * most) {
    fail(place, "Draco header announces " + std::to_string(counts.faces) + " triangles and " +
                    std::to_string(counts.points) + " vertices in " + std::to_string(stored) +
                    " bytes");
  }
  budget.takeVertices(counts.points);
  budget.takeBytes(kBytesPerFace * std::max(counts.faces, counts.points));
}

/// Integers become floats as the glTF accessor says, whatever the stream's own flag.
glm::vec3 positionAt(const draco::PointAttribute& attribute, draco::AttributeValueIndex value,
                     bool normalized) {
  std::array<float, 3> p{};
  if (attribute.data_type() == draco::DT_FLOAT32) {
    attribute.ConvertValue<float>(value, 3, p.data());
    return {p[0], p[1], p[2]};
  }
  std::array<std::int32_t, 3> whole{};
  attribute.ConvertValue<std::int32_t>(value, 3, whole.data());
  float unit = 1.0F;
  if (normalized) {
    switch (attribute.data_type()) {
      case draco::DT_INT8:
        unit = 127.0F;
        break;
      case draco::DT_UINT8:
        unit = 255.0F;
        break;
      case draco::DT_INT16:
        unit = 32767.0F;
        break;
      case draco::DT_UINT16:
        unit = 65535.0F;
        break;
      default:
        break;
    }
  }
  for (std::size_t i = 0; i < 3; ++i) {
    p[i] = static_cast<float>(whole[i]) / unit;
    if (normalized) p[i] = std::max(p[i], -1.0F);
  }
  return {p[0], p[1], p[2]};
}

bool isCoordinate(draco::DataType type) {
  return type == draco::DT_FLOAT32 || type == draco::DT_INT8 || type == draco::DT_UINT8 ||
         type == draco::DT_INT16 || type == draco::DT_UINT16;
}

void copyMesh(const draco::Mesh& mesh, const DracoPositions& wanted, const Place& place,
              RawSurface& surface) {
  const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(wanted.attribute_id);
  if (attribute == nullptr) {
    fail(place, "Draco attribute " + std::to_string(wanted.attribute_id) + " is not in the stream");
  }
  if (attribute->num_components() != 3 || !isCoordinate(attribute->data_type())) {
    fail(place, "Draco attribute " + std::to_string(wanted.attribute_id) + " holds no positions");
  }
  surface.positions.reserve(mesh.num_points());
  for (draco::PointIndex p(0); p < mesh.num_points(); ++p) {
    const draco::AttributeValueIndex value = attribute->mapped_index(p);
    if (value.value() >= attribute->size()) fail(place, "the Draco stream is broken");
    surface.positions.push_back(positionAt(*attribute, value, wanted.normalized));
  }
  surface.indices.reserve(std::size_t{3} * mesh.num_faces());
  for (draco::FaceIndex f(0); f < mesh.num_faces(); ++f) {
    for (const draco::PointIndex& corner : mesh.face(f)) {
      if (corner.value() >= mesh.num_points()) fail(place, "the Draco stream is broken");
      surface.indices.push_back(corner.value());
    }
  }
}

}  // namespace

void decodeDraco(std::span<const std::byte> stored, const DracoPositions& wanted,
                 const Place& place, Budget& budget, RawSurface& surface) {
  checkCounts(readCounts(stored, place), stored.size(), place, budget);
  draco::DecoderBuffer buffer = bufferOf(stored);
  draco::Decoder decoder;
  auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
  if (!decoded.ok()) fail(place, "the Draco stream is broken");
  const std::unique_ptr<draco::Mesh> mesh = std::move(decoded).value();
  copyMesh(*mesh, wanted, place, surface);
}

}  // namespace culld::gltf
