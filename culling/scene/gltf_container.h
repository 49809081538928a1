// The outer shape of a file: a GLB container or plain JSON. Checks every length against the bytes
// that are there (glTF 2.0, section 4).
#pragma once
#include <cstddef>
#include <span>
#include <string_view>

namespace culld::gltf {

struct Container {
  std::string_view json;
  std::span<const std::byte> binary;  ///< the BIN chunk
  bool is_glb = false;
  bool has_binary = false;
};

/// Points into `file`. Throws LoadFailure.
Container openContainer(std::span<const std::byte> file);

}  // namespace culld::gltf
