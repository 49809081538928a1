// What a scene looks like to somebody who asks why a plan is as it is. Estimated from the boxes of
// at most 2048 objects and rays from sampled views; decides nothing.
#pragma once
#include <cstddef>

#include "culling/scene/scene_snapshot.h"

namespace culld {

struct SceneShape {
  // Diagonals of the objects' boxes: one in ten is smaller, half are, nine in ten are.
  double small_m = 0.0, median_m = 0.0, large_m = 0.0;
  double triangles_per_object = 0.0;
  double depth_complexity = 0.0;    ///< boxes that a ray meets, mean
  double occluder_potential = 0.0;  ///< share of rays on which a blocker stands before something
  double closedness = 0.0;          ///< share of rays from among the objects that a blocker ends
  /// Share of objects on whose vertical all boxes make one heap: 1 for streets, less with bridges
  /// and storeys.
  double upright = 0.0;
};

/// Deterministic. COST: some milliseconds, whatever the size of the scene.
SceneShape shapeOf(const SceneSnapshot& scene);

}  // namespace culld
