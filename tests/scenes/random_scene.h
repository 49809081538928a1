// Small random scenes and cameras that look for trouble: everything that has ever broken a culler,
// thrown together at any scale and place.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/scene/scene_snapshot.h"
#include "tests/scenes/camera_spec.h"
#include "tests/scenes/model.h"

namespace culld::scenes {

struct RandomSceneOptions {
  std::uint32_t objects = 60;  ///< about; some sorts come in groups
  double max_offset_m = 1e7;   ///< the whole scene is moved by up to this
  bool any_scale = true;       ///< the whole scene is scaled by 1e-3 ... 1e4
  bool odd_transforms = true;  ///< mirrored, sheared, flat
  bool see_through = true;     ///< MASK and BLEND surfaces among the others
};

/// Boxes, walls, closed convex and concave bodies, open sheets, T-junctions, abutting walls,
/// slivers, coplanar copies, nested boxes, a large ground, walls with needle holes. Every node is
/// an object without a parent: object id == node index. Same seed and options, same model.
Model randomModel(std::uint64_t seed, const RandomSceneOptions& options = {});
SnapshotPtr randomScene(std::uint64_t seed, const RandomSceneOptions& options = {});

/// Cameras for any scene: wide and narrow, inside and outside objects, on surfaces, along walls,
/// off-centre, oblique, infinitely far, reversed depth, orthographic, mirrored. All are valid.
std::vector<CameraSpec> randomCameras(std::uint64_t seed, const SceneSnapshot& scene,
                                      std::size_t count);

}  // namespace culld::scenes
