#include "culling/methods/item_buffer_meshes.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>

namespace culld {
namespace {

std::uint64_t nextKey() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

ItemRun runOf(const Surface& surface) {
  if (surface.blocks) return surface.double_sided ? kBlockBoth : kBlockFront;
  return surface.double_sided ? kShowBoth : kShowFront;
}

}  // namespace

ItemMeshes::ItemMeshes(const SceneSnapshot& scene) : meshes_(scene.meshCount()), key_(nextKey()) {
  for (MeshId id = 0; id < scene.meshCount(); ++id) {
    const Mesh& mesh = scene.mesh(id);
    ItemMesh& item = meshes_[id];
    if (mesh.unbounded) continue;  // always kept, and never blocks
    item.thin = mesh.points_and_lines != 0;
    for (int axis = 0; axis < 3 && !mesh.bounds.empty(); ++axis) {
      item.largest[axis] =
          std::max(std::abs(mesh.bounds.min[axis]), std::abs(mesh.bounds.max[axis]));
    }
    for (const Surface& surface : mesh.surfaces) {
      item.runs[runOf(surface)].index_count += 3 * surface.triangle_count;
    }
    for (ItemMesh::Run& run : item.runs) {
      run.first_index = static_cast<std::uint32_t>(indices_);
      indices_ += run.index_count;
    }
    vertices_ += mesh.positions.size();
  }
}

gpu::MeshSource ItemMeshes::source(const SceneSnapshot& scene) const {
  const auto fill = [this, &scene](std::vector<std::uint32_t>& out) {
    for (MeshId id = 0; id < meshes_.size(); ++id) {
      if (scene.mesh(id).unbounded) continue;
      for (const glm::vec3& p : scene.mesh(id).positions) {
        for (const float x : {p.x, p.y, p.z}) out.push_back(std::bit_cast<std::uint32_t>(x));
      }
    }
    std::uint32_t first = 0;  // vertex of the mesh
    for (MeshId id = 0; id < meshes_.size(); ++id) {
      const Mesh& mesh = scene.mesh(id);
      if (mesh.unbounded) continue;
      for (std::uint8_t run = 0; run < kItemRuns; ++run) {
        for (const Surface& surface : mesh.surfaces) {
          if (runOf(surface) != run) continue;
          for (std::uint32_t t = 0; t < surface.triangle_count; ++t) {
            for (const std::uint32_t corner : mesh.triangles[surface.first_triangle + t]) {
              out.push_back(first + corner);
            }
          }
        }
      }
      first += static_cast<std::uint32_t>(mesh.positions.size());
    }
  };
  return {key_, vertices_, indices_, fill};
}

}  // namespace culld
