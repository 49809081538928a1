// Any bytes are a scene or one line that says why not: no crash, no blow-up, and a scene whose
// indices all hold.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>

#include "culling/scene/gltf_loader.h"

namespace {

void require(bool holds) {
  if (!holds) std::abort();
}

void checkMesh(const culld::Mesh& mesh) {
  std::uint64_t covered = 0;
  for (const culld::Surface& surface : mesh.surfaces) {
    require(surface.first_triangle == covered);
    covered += surface.triangle_count;
  }
  require(covered == mesh.triangles.size());
  require(mesh.partners.size() == 3 * mesh.triangles.size());
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) {
      require(corner < mesh.positions.size());
      const glm::vec3 p = mesh.positions[corner];
      require(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z));
    }
  }
  for (const std::uint32_t partner : mesh.partners) {
    require(partner == culld::kOpenEdge || partner < mesh.partners.size());
  }
}

void checkScene(const culld::SceneSnapshot& scene) {
  for (culld::MeshId m = 0; m < scene.meshCount(); ++m) checkMesh(scene.mesh(m));
  for (culld::ObjectId id = 0; id < scene.objectCount(); ++id) {
    const culld::Instance& instance = scene.instance(id);
    require(instance.mesh < scene.meshCount());
    require(!instance.hidden && !instance.removed);
    require(instance.always_kept || instance.bounds_world.empty() ||
            instance.bounds_world.finite());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  culld::LoadOptions options;
  options.threads = 1;
  options.limits.max_file_bytes = 1U << 20;
  options.limits.max_objects = 4096;
  options.limits.max_vertices = 1U << 18;
  options.limits.max_decoded_bytes = 1U << 26;
  const auto bytes = std::as_bytes(std::span(data, size));
  const culld::Result<culld::SnapshotPtr> scene = culld::loadGltfBytes(bytes, "fuzz", options);
  if (scene.ok()) {
    checkScene(*scene.value());
  } else {
    const std::string& line = scene.error().message;
    require(line.starts_with("fuzz: ") && line.size() > 6 && line.size() < 1000);
    require(line.find('\n') == line.npos);
  }
  return 0;
}
