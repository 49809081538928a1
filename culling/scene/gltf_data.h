// The bytes behind buffer views and accessors: resolved, decompressed, range-checked.
#pragma once
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "culling/scene/gltf_budget.h"
#include "culling/scene/gltf_bytes.h"
#include "culling/scene/gltf_container.h"
#include "culling/scene/gltf_document.h"

namespace culld::gltf {

/// An accessor without a buffer view costs a file nothing, so its count is held to this.
inline constexpr std::uint64_t kMaxUnbackedElements = std::uint64_t{1} << 20;

class DataSource {
 public:
  /// Reads data URIs and, if `folder` is given, files below it. Throws LoadFailure.
  DataSource(const Document& document, const Container& container,
             const std::optional<std::string>& folder, std::uint64_t max_bytes);

  /// Decompresses the views that these accessors lie in, once each, in parallel.
  void prepare(std::span<const std::uint32_t> accessors, Budget& budget, std::size_t threads);

  const Document& document() const noexcept { return document_; }
  /// Bytes of a buffer view as stored, before meshopt. Throws if the buffer has none.
  std::span<const std::byte> stored(std::uint32_t view, const Place& place) const;
  /// Bytes of a buffer view as accessors see them. REQUIRES: prepared for one of its accessors.
  std::span<const std::byte> view(std::uint32_t view, const Place& place) const;

 private:
  std::span<const std::byte> bufferBytes(std::uint32_t buffer, std::uint64_t offset,
                                         std::uint64_t length, const Place& place) const;
  void resolve(std::uint32_t buffer, const std::optional<std::string>& folder,
               std::uint64_t& max_bytes);

  const Document& document_;
  std::vector<std::span<const std::byte>> buffers_;
  std::vector<bool> present_;
  std::vector<OwnedBytes> owned_;
  std::vector<OwnedBytes> decompressed_;  // per view
};

/// The numbers of one accessor, sparse parts applied, read one element at a time.
class ElementReader {
 public:
  /// Throws LoadFailure: past its buffer view, a stride below the element, sparse indices out of
  /// range. A sparse accessor is copied, and the copy is taken from the budget.
  ElementReader(const DataSource& data, std::uint32_t accessor, Budget& budget);

  std::uint64_t count() const noexcept { return count_; }
  std::uint8_t width() const noexcept { return width_; }
  Component component() const noexcept { return component_; }
  bool normalized() const noexcept { return normalized_; }
  /// REQUIRES: element < count(), part < width(), an integer component.
  std::uint32_t unsignedAt(std::uint64_t element, std::size_t part = 0) const noexcept;
  float floatAt(std::uint64_t element, std::size_t part) const noexcept;
  /// REQUIRES: width() == 3.
  glm::vec3 vec3At(std::uint64_t element) const noexcept;

 private:
  void applySparse(const DataSource& data, const Accessor& accessor, const Place& place,
                   Budget& budget);

  const std::byte* base_ = nullptr;  // none: all zero
  std::size_t stride_ = 0;
  std::uint64_t count_ = 0;
  Component component_ = Component::kFloat;
  std::uint8_t width_ = 1;
  bool normalized_ = false;
  OwnedBytes dense_;  // base_ points here for sparse accessors
};

/// Decodes an EXT_meshopt_compression view. Throws LoadFailure.
OwnedBytes decodeMeshopt(const MeshoptView& view, std::span<const std::byte> stored,
                         const Place& place, Budget& budget);

}  // namespace culld::gltf
