// Bytes that the loader owns: files, decoded data URIs, decompressed views. Not zeroed first.
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace culld::gltf {

class OwnedBytes {
 public:
  OwnedBytes() = default;
  explicit OwnedBytes(std::size_t size)
      : data_(std::make_unique_for_overwrite<std::byte[]>(size)), size_(size) {}
  std::byte* data() noexcept { return data_.get(); }
  std::size_t size() const noexcept { return size_; }
  std::span<const std::byte> span() const noexcept { return {data_.get(), size_}; }

 private:
  std::unique_ptr<std::byte[]> data_;
  std::size_t size_ = 0;
};

/// The first `wanted` bytes of a regular file, or all of it if `wanted` is 0. Never opens devices,
/// directories or pipes for reading. Throws LoadFailure without a place: "No such file", ...
OwnedBytes readRegularFile(const std::string& path, std::uint64_t wanted, std::uint64_t at_most);

/// Text from a file, safe to show on one line: control characters become '?', long text is cut.
std::string shown(const std::string& text);

}  // namespace culld::gltf
