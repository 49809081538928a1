// Some objects for all: what the planner looks at to learn what a scene is like.
#pragma once
#include <cstddef>
#include <vector>

#include "culling/core/ids.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

/// Every n-th object, those without a bound left out: at least `enough` are looked at if there are
/// so many, and fewer than twice as many.
std::vector<ObjectId> sampledObjects(const SceneSnapshot& scene, std::size_t enough);

}  // namespace culld
