#include "culling/planner/sampled_objects.h"

#include <algorithm>

namespace culld {

std::vector<ObjectId> sampledObjects(const SceneSnapshot& scene, std::size_t enough) {
  std::vector<ObjectId> objects;
  const std::size_t step = std::max<std::size_t>(1, scene.objectCount() / enough);
  for (std::size_t i = 0; i < scene.objectCount(); i += step) {
    const auto id = static_cast<ObjectId>(i);
    const Instance& instance = scene.instance(id);
    if (!instance.active() || instance.always_kept || !instance.bounds_world.finite()) continue;
    objects.push_back(id);
  }
  return objects;
}

}  // namespace culld
