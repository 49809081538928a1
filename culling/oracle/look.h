// One look from one pose: samples all over the image, then rounds of rays aimed at what no sample
// met; counted per object. docs/oracle.md says what the rounds are for.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/core/camera.h"
#include "culling/core/ids.h"
#include "culling/oracle/oracle.h"
#include "culling/oracle/ray_scene.h"

namespace culld::oracle {

/// What the rays of one look had to do with an object in the frustum.
struct Sighting {
  ObjectId object = 0;
  std::uint32_t samples = 0;  ///< that met it
  std::uint32_t rounds = 0;   ///< of aimed rays of which one met it
  bool tie = false;           ///< met at the depth of what blocks only
  bool seen() const noexcept { return samples > 0 || rounds > 0; }
};

struct LookResult {
  std::vector<Sighting> objects;  ///< ascending by object: all whose boxes reach into the frustum
  double pixels_per_sample = 1.0;
  std::uint32_t rounds = 0;
  std::uint64_t rays = 0;
};

/// REQUIRES: `view` made for `camera`. The seed is `options.seed`. GUARANTEES: equal inputs give
/// equal results for any number of threads.
LookResult lookFrom(const RayView& view, const Camera& camera, const OracleOptions& options);

}  // namespace culld::oracle
