// Where to aim at an object that no ray has met yet: random points of its triangles, and points
// just inside of corners and edges, where things peep out from behind others.
#pragma once
#include <cstdint>
#include <optional>

#include "culling/oracle/ray_scene.h"

namespace culld::oracle {

/// Random numbers that depend on nothing but what they are for (G. Steele et al., SplitMix64,
/// 2014).
class Random {
 public:
  Random(std::uint64_t seed, std::uint64_t what, std::uint64_t which);
  std::uint64_t next();
  double unit();  ///< in [0, 1)

 private:
  std::uint64_t state_;
};

/// Aimed ray number `number` at the object. None if the point drawn is outside of the frustum or on
/// the side of a triangle that is never seen.
std::optional<Ray> aimAt(const RayView& view, const RayView::Placed& placed, std::uint32_t number,
                         Random& random);

}  // namespace culld::oracle
