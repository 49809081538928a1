#include "culling/methods/gpu_depth_pyramid_occluders.h"

namespace culld {

GpuOccluders GpuOccluders::of(const SceneSnapshot& scene, std::size_t faces) {
  GpuOccluders out;
  out.pieces_ = OccluderSet::of(scene);
  out.faces_.resize(scene.meshCount());
  for (MeshId id = 0; id < scene.meshCount(); ++id) {
    const bool needed = out.pieces_.mesh(id).piece_count == 0 && !scene.mesh(id).unbounded;
    if (needed && faces != 0) out.faces_[id] = ConvexPieces::facesOf(scene.mesh(id), faces);
  }
  return out;
}

std::size_t GpuOccluders::bytes() const noexcept {
  std::size_t bytes = pieces_.bytes() + faces_.capacity() * sizeof(ConvexPieces);
  for (const ConvexPieces& faces : faces_) bytes += faces.bytes();
  return bytes;
}

}  // namespace culld
