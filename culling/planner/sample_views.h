// Cameras in a scene that nobody described: what the planner looks through before a client does.
#pragma once
#include <cstddef>
#include <vector>

#include "culling/core/camera.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

struct SampledView {
  Camera camera;
  bool outside = false;  ///< looks over the scene from outside
};

/// Most stand beside an object, at the height of a person's eyes where the scene is large enough
/// for one, and look along the ground or at another object; every fourth looks over the scene from
/// outside. The same for the same scene on every machine. Empty if the scene has no object with a
/// bound. y is up and lengths are metres, as in glTF.
std::vector<SampledView> sampleViews(const SceneSnapshot& scene, std::size_t count);

}  // namespace culld
