// glTF 2.0 (.glb, .gltf) into a snapshot. docs/scenes.md says what is read.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "culling/core/result.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

/// What a file may ask for at most; past it loading ends with kLimit.
struct LoadLimits {
  std::uint64_t max_file_bytes = std::uint64_t{4} << 30;  ///< external buffers included
  std::uint64_t max_objects = 16'000'000;
  std::uint64_t max_vertices = 1'000'000'000;  ///< over all meshes, decoded
  std::uint64_t max_decoded_bytes = std::uint64_t{16} << 30;
};

struct LoadOptions {
  LoadLimits limits;
  std::size_t threads = 0;  ///< 0: as many as cores
  /// Called now and then with (done, total) parts, from any thread, one call at a time.
  std::function<void(std::size_t done, std::size_t total)> progress;
};

/// ERROR: one line "FILE: place: what", e.g. "city.glb: mesh 3: index 91 >= 88 vertices".
Result<SnapshotPtr> loadGltfFile(const std::string& path, const LoadOptions& options = {});

/// The same from memory; `name` stands for the file in messages. External buffers are not read.
Result<SnapshotPtr> loadGltfBytes(std::span<const std::byte> bytes, const std::string& name,
                                  const LoadOptions& options = {});

}  // namespace culld
