#include "culling/planner/scene_profile.h"

#include "culling/planner/overhang.h"

namespace culld {

SceneProfile profileScene(const SceneSnapshot& scene) {
  SceneProfile profile;
  for (std::size_t i = 0; i < scene.objectCount(); ++i) {
    const Instance& instance = scene.instance(static_cast<ObjectId>(i));
    if (!instance.active()) continue;
    ++profile.objects;
    const Mesh& mesh = scene.mesh(instance.mesh);
    profile.triangles += mesh.triangles.size();
    if (!instance.always_kept) profile.blocking_triangles += mesh.blocking_triangles;
  }
  profile.overhang = overhangOf(scene);
  return profile;
}

}  // namespace culld
