// What loading may still decode. Counts before memory is asked for.
#pragma once
#include <atomic>
#include <cstdint>
#include <string>

#include "culling/scene/gltf_failure.h"
#include "culling/scene/gltf_loader.h"

namespace culld::gltf {

/// THREADS: any. Throws LoadFailure (kLimit); the message is the same whichever part was too much.
class Budget {
 public:
  explicit Budget(const LoadLimits& limits)
      : max_vertices_(limits.max_vertices), max_bytes_(limits.max_decoded_bytes) {}

  void takeVertices(std::uint64_t n) { take(n, vertices_, max_vertices_, " vertices"); }
  void takeBytes(std::uint64_t n) { take(n, bytes_, max_bytes_, " decoded bytes"); }

 private:
  static void take(std::uint64_t n, std::atomic<std::uint64_t>& used, std::uint64_t limit,
                   const char* what) {
    // The first test keeps the sum from wrapping.
    if (n > limit || used.fetch_add(n) > limit - n) {
      fail(ErrorCode::kLimit, "scene: more than " + std::to_string(limit) + what);
    }
  }

  std::uint64_t max_vertices_, max_bytes_;
  std::atomic<std::uint64_t> vertices_{0}, bytes_{0};
};

}  // namespace culld::gltf
