#include "culling/planner/scene_profile.h"

#include <vector>

namespace culld {

SceneProfile profileScene(const SceneSnapshot& scene) {
  std::vector<std::uint64_t> blocking(scene.meshCount(), 0);
  for (std::size_t m = 0; m < scene.meshCount(); ++m) {
    const Mesh& mesh = scene.mesh(static_cast<MeshId>(m));
    if (mesh.unbounded) continue;
    for (const Surface& surface : mesh.surfaces) {
      if (surface.blocks) blocking[m] += surface.triangle_count;
    }
  }
  SceneProfile profile;
  for (std::size_t i = 0; i < scene.objectCount(); ++i) {
    const Instance& instance = scene.instance(static_cast<ObjectId>(i));
    if (!instance.active()) continue;
    ++profile.objects;
    profile.triangles += scene.mesh(instance.mesh).triangles.size();
    if (!instance.always_kept) profile.blocking_triangles += blocking[instance.mesh];
  }
  return profile;
}

}  // namespace culld
