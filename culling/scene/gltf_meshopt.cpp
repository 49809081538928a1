// EXT_meshopt_compression, decoded by meshoptimizer.
#include <meshoptimizer.h>

#include "culling/scene/gltf_data.h"

namespace culld::gltf {
namespace {

/// No stream of the codecs expands further: attributes need at least 4 bytes per 256 elements and
/// byte of stride, indices at least one byte per triangle.
constexpr std::uint64_t kMaxExpansion = 64;

int decode(const MeshoptView& view, std::span<const std::byte> stored, std::byte* out) {
  const auto* in = reinterpret_cast<const unsigned char*>(stored.data());
  switch (view.mode) {
    case MeshoptMode::kAttributes:
      return meshopt_decodeVertexBuffer(out, view.count, view.stride, in, stored.size());
    case MeshoptMode::kTriangles:
      return meshopt_decodeIndexBuffer(out, view.count, view.stride, in, stored.size());
    case MeshoptMode::kIndices:
      break;
  }
  return meshopt_decodeIndexSequence(out, view.count, view.stride, in, stored.size());
}

void filter(const MeshoptView& view, std::byte* out) {
  switch (view.filter) {
    case MeshoptFilter::kPlain:
      break;
    case MeshoptFilter::kOctahedral:
      meshopt_decodeFilterOct(out, view.count, view.stride);
      break;
    case MeshoptFilter::kQuaternion:
      meshopt_decodeFilterQuat(out, view.count, view.stride);
      break;
    case MeshoptFilter::kExponential:
      meshopt_decodeFilterExp(out, view.count, view.stride);
      break;
  }
}

}  // namespace

OwnedBytes decodeMeshopt(const MeshoptView& view, std::span<const std::byte> stored,
                         const Place& place, Budget& budget) {
  if (view.count / kMaxExpansion > stored.size()) {
    fail(place, std::to_string(view.count) + " meshopt elements from " +
                    std::to_string(stored.size()) + " bytes");
  }
  const std::uint64_t size = view.count * view.stride;
  budget.takeBytes(size);
  OwnedBytes bytes(size);
  if (decode(view, stored, bytes.data()) != 0) fail(place, "the meshopt stream is broken");
  filter(view, bytes.data());
  return bytes;
}

}  // namespace culld::gltf
