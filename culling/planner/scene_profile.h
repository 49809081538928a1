// What a scene is like, counted once per snapshot: enough to say which methods are for it.
#pragma once
#include "culling/culler.h"

namespace culld {

/// Counts active objects and their triangles; every instance of a mesh counts.
/// COST: O(objects + surfaces), and some milliseconds at most (overhang.h).
SceneProfile profileScene(const SceneSnapshot& scene);

}  // namespace culld
