#include "culling/scene/gltf_data.h"

#include <algorithm>
#include <exception>

#include "culling/core/parallel.h"
#include "culling/scene/gltf_uri.h"

namespace culld::gltf {

DataSource::DataSource(const Document& document, const Container& container,
                       const std::optional<std::string>& folder, std::uint64_t max_bytes)
    : document_(document),
      buffers_(document.buffers.size()),
      present_(document.buffers.size()),
      owned_(document.buffers.size()),
      decompressed_(document.views.size()) {
  for (std::uint32_t i = 0; i < document.buffers.size(); ++i) {
    const Buffer& buffer = document.buffers[i];
    if (buffer.fallback) continue;  // only its compressed twin is read
    if (buffer.has_uri) {
      resolve(i, folder, max_bytes);
    } else if (i == 0 && container.has_binary) {
      if (buffer.byte_length > container.binary.size()) {
        fail(Place{"buffer", i}, std::to_string(buffer.byte_length) +
                                     " bytes announced, the BIN chunk has " +
                                     std::to_string(container.binary.size()));
      }
      buffers_[i] = container.binary.first(buffer.byte_length);
      present_[i] = true;
    }
  }
}

void DataSource::resolve(std::uint32_t i, const std::optional<std::string>& folder,
                         std::uint64_t& max_bytes) {
  const Buffer& buffer = document_.buffers[i];
  const std::string place = Place{"buffer", i}.text();
  try {
    if (isDataUri(buffer.uri)) {
      owned_[i] = decodeDataUri(buffer.uri);
    } else {
      const std::string path = relativePath(buffer.uri);
      if (!folder) fail(ErrorCode::kUnsupported, "external buffers are not read here");
      owned_[i] = readRegularFile(*folder + path, buffer.byte_length, max_bytes);
      max_bytes -= owned_[i].size();
    }
  } catch (const LoadFailure& failure) {
    const std::string uri = isDataUri(buffer.uri) ? "" : shown(buffer.uri) + ": ";
    fail(failure.error().code, place + ": " + uri + failure.error().message);
  }
  if (owned_[i].size() < buffer.byte_length) {
    fail(place, std::to_string(buffer.byte_length) + " bytes announced, its URI has " +
                    std::to_string(owned_[i].size()));
  }
  buffers_[i] = owned_[i].span().first(buffer.byte_length);
  present_[i] = true;
}

void DataSource::prepare(std::span<const std::uint32_t> accessors, Budget& budget,
                         std::size_t threads) {
  std::vector<std::uint32_t> views;
  const auto want = [&](std::uint32_t view) {
    if (view != kNone && document_.views[view].meshopt) views.push_back(view);
  };
  for (const std::uint32_t a : accessors) {
    const Accessor& accessor = document_.accessors[a];
    want(accessor.view);
    if (!accessor.sparse) continue;
    want(accessor.sparse->indices_view);
    want(accessor.sparse->values_view);
  }
  std::sort(views.begin(), views.end());
  views.erase(std::unique(views.begin(), views.end()), views.end());
  std::vector<std::exception_ptr> failures(views.size());
  parallelFor(
      views.size(),
      [&](std::size_t k) {
        const Place place{"bufferView", views[k]};
        const MeshoptView& packed = *document_.views[views[k]].meshopt;
        try {
          decompressed_[views[k]] =
              decodeMeshopt(packed, bufferBytes(packed.buffer, packed.offset, packed.length, place),
                            place, budget);
        } catch (...) {
          failures[k] = std::current_exception();
        }
      },
      threads);
  for (const std::exception_ptr& failure : failures) {
    if (failure) std::rethrow_exception(failure);
  }
}

std::span<const std::byte> DataSource::bufferBytes(std::uint32_t buffer, std::uint64_t offset,
                                                   std::uint64_t length, const Place& place) const {
  if (!present_[buffer]) fail(place, "buffer " + std::to_string(buffer) + " has no bytes");
  return buffers_[buffer].subspan(offset, length);
}

std::span<const std::byte> DataSource::stored(std::uint32_t view, const Place& place) const {
  const BufferView& v = document_.views[view];
  return bufferBytes(v.buffer, v.offset, v.length, place);
}

std::span<const std::byte> DataSource::view(std::uint32_t view, const Place& place) const {
  return document_.views[view].meshopt ? decompressed_[view].span() : stored(view, place);
}

}  // namespace culld::gltf
