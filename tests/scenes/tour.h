// A path through a scene that nobody knows: for the demo over a user's own file.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/scene/scene_snapshot.h"
#include "tests/scenes/camera_spec.h"

namespace culld::scenes {

/// Half of the cameras circle the scene and look at its middle, half walk through it in a ring and
/// look ahead. "The scene" is where nine tenths of the objects are, so that a sky dome or a stray
/// object does not send everybody far away. GUARANTEES: every camera is one toCamera() accepts.
std::vector<CameraSpec> tourCameras(const SceneSnapshot& scene, std::uint32_t frames);

}  // namespace culld::scenes
