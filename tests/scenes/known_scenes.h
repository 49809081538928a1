// Scenes made by hand whose answers can be read off: what must be answered, and what a good
// occlusion method leaves out.
#pragma once
#include <string>
#include <vector>

#include "culling/core/ids.h"
#include "culling/scene/scene_snapshot.h"
#include "tests/scenes/camera_spec.h"
#include "tests/scenes/model.h"

namespace culld::scenes {

struct KnownScene {
  std::string name;
  Model model;
  SnapshotPtr snapshot;  ///< toSnapshot(model)
  CameraSpec camera;
  std::vector<ObjectId> must_be_visible;  ///< ascending; in E, so in every conservative answer
  std::vector<ObjectId> can_be_hidden;    ///< ascending; provably not in E, with room to spare:
                                          ///< a good occlusion method leaves them out
  std::vector<ObjectId> outside;          ///< ascending; outside the frustum by a wide margin
};

std::vector<KnownScene> knownScenes();

}  // namespace culld::scenes
