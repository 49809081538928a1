// Reading accessors. All component types go through memcpy: files may misalign them.
#include <algorithm>
#include <cstring>

#include "culling/scene/gltf_data.h"

namespace culld::gltf {
namespace {

template <typename T>
T load(const std::byte* from) noexcept {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

float normalizedSigned(int value, int largest) noexcept {
  return std::max(static_cast<float>(value) / static_cast<float>(largest), -1.0F);
}

std::uint32_t loadUnsigned(const std::byte* from, Component component) noexcept {
  switch (component) {
    case Component::kInt8:
    case Component::kUint8:
      return load<std::uint8_t>(from);
    case Component::kInt16:
    case Component::kUint16:
      return load<std::uint16_t>(from);
    case Component::kUint32:
    case Component::kFloat:
      break;
  }
  return load<std::uint32_t>(from);
}

float loadFloat(const std::byte* from, Component component, bool normalized) noexcept {
  switch (component) {
    case Component::kInt8: {
      const int v = load<std::int8_t>(from);
      return normalized ? normalizedSigned(v, 127) : static_cast<float>(v);
    }
    case Component::kUint8: {
      const auto v = static_cast<float>(load<std::uint8_t>(from));
      return normalized ? v / 255.0F : v;
    }
    case Component::kInt16: {
      const int v = load<std::int16_t>(from);
      return normalized ? normalizedSigned(v, 32767) : static_cast<float>(v);
    }
    case Component::kUint16: {
      const auto v = static_cast<float>(load<std::uint16_t>(from));
      return normalized ? v / 65535.0F : v;
    }
    case Component::kUint32:
      return static_cast<float>(load<std::uint32_t>(from));
    case Component::kFloat:
      break;
  }
  return load<float>(from);
}

/// `count` elements of `element` bytes, `stride` apart, from `offset` on, must lie in the bytes.
void checkFits(std::span<const std::byte> bytes, std::uint64_t offset, std::uint64_t stride,
               std::uint64_t count, std::uint64_t element, const Place& place) {
  const bool fits = offset <= bytes.size() && element <= bytes.size() - offset &&
                    (count - 1) <= (bytes.size() - offset - element) / stride;
  if (fits) return;
  fail(place, std::to_string(count) + " elements of " + std::to_string(stride) +
                  " bytes from byte " + std::to_string(offset) + " do not fit into " +
                  std::to_string(bytes.size()) + " bytes");
}

}  // namespace

ElementReader::ElementReader(const DataSource& data, std::uint32_t index, Budget& budget) {
  const Accessor& accessor = data.document().accessors[index];
  const Place place{"accessor", index};
  count_ = accessor.count;
  component_ = accessor.component;
  width_ = accessor.width;
  normalized_ = accessor.normalized;
  if (width_ == 0) fail(place, "unknown type");
  const std::size_t element = bytesOf(component_) * width_;
  stride_ = element;
  if (accessor.view == kNone) {
    if (count_ > kMaxUnbackedElements) {
      fail(ErrorCode::kLimit, place.text() + ": " + std::to_string(count_) +
                                  " elements without a bufferView > limit of " +
                                  std::to_string(kMaxUnbackedElements));
    }
  } else {
    const BufferView& view = data.document().views[accessor.view];
    // A meshopt view has its own stride; the view's repeats it.
    const std::uint32_t given = view.meshopt ? view.meshopt->stride : view.stride;
    if (given != 0) stride_ = given;
    if (stride_ < element) {
      fail(place, "byteStride " + std::to_string(stride_) + " < " + std::to_string(element) +
                      " bytes of an element");
    }
    const std::span<const std::byte> bytes = data.view(accessor.view, place);
    checkFits(bytes, accessor.offset, stride_, count_, element, place);
    base_ = bytes.data() + accessor.offset;
  }
  if (accessor.sparse) applySparse(data, accessor, place, budget);
}

void ElementReader::applySparse(const DataSource& data, const Accessor& accessor,
                                const Place& place, Budget& budget) {
  const SparsePart& sparse = *accessor.sparse;
  const std::size_t element = bytesOf(component_) * width_;
  budget.takeBytes(count_ * element);
  dense_ = OwnedBytes(count_ * element);
  for (std::uint64_t i = 0; i < count_; ++i) {
    std::byte* to = dense_.data() + i * element;
    if (base_ == nullptr) {
      std::memset(to, 0, element);
    } else {
      std::memcpy(to, base_ + i * stride_, element);
    }
  }
  base_ = dense_.data();
  stride_ = element;
  if (sparse.count == 0) return;

  const std::span<const std::byte> indices = data.view(sparse.indices_view, place);
  const std::span<const std::byte> values = data.view(sparse.values_view, place);
  const std::size_t index_bytes = bytesOf(sparse.indices_component);
  checkFits(indices, sparse.indices_offset, index_bytes, sparse.count, index_bytes, place);
  checkFits(values, sparse.values_offset, element, sparse.count, element, place);
  std::uint64_t next = 0;
  for (std::uint64_t i = 0; i < sparse.count; ++i) {
    const std::uint32_t target = loadUnsigned(
        indices.data() + sparse.indices_offset + i * index_bytes, sparse.indices_component);
    if (target >= count_) {
      fail(place, "sparse index " + std::to_string(target) + " >= " + std::to_string(count_) +
                      " elements");
    }
    if (target < next) fail(place, "sparse indices do not increase");
    next = std::uint64_t{target} + 1;
    std::memcpy(dense_.data() + target * element,
                values.data() + sparse.values_offset + i * element, element);
  }
}

std::uint32_t ElementReader::unsignedAt(std::uint64_t i, std::size_t part) const noexcept {
  if (base_ == nullptr) return 0;
  return loadUnsigned(base_ + i * stride_ + part * bytesOf(component_), component_);
}

float ElementReader::floatAt(std::uint64_t i, std::size_t part) const noexcept {
  if (base_ == nullptr) return 0.0F;
  return loadFloat(base_ + i * stride_ + part * bytesOf(component_), component_, normalized_);
}

glm::vec3 ElementReader::vec3At(std::uint64_t i) const noexcept {
  return {floatAt(i, 0), floatAt(i, 1), floatAt(i, 2)};
}

}  // namespace culld::gltf
