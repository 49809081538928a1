// A second opinion on rays: no hierarchy, no Embree, other formulas, every triangle of every object
// in long double. Slow on purpose; it judges culling/oracle on small scenes.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/core/camera.h"
#include "culling/scene/scene_snapshot.h"

namespace culld::oracle_test {

struct Vec {
  long double x = 0, y = 0, z = 0;
};

/// A segment of a ray; points are relative to the camera's origin.
struct BruteRay {
  Vec origin, direction;
  long double t_min = 0, t_max = 0;
};

struct BruteHit {
  ObjectId object = 0;
  long double t = 0;
  /// How far inside the triangle, as the smallest barycentric coordinate. Near 0: on its rim.
  long double inside = 0;
  long double facing = 0;  ///< cosine between the triangle's plane normal and the ray
  bool blocks = false;
  bool side_known = true;  ///< false: single-sided under a transform that may or may not mirror
};

/// Surfaces met from the side they are seen from, in no order.
std::vector<BruteHit> bruteHits(const SceneSnapshot& scene, const Camera& camera,
                                const BruteRay& ray);

}  // namespace culld::oracle_test
