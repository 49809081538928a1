// Where to aim the rays that look for what no sample has met: at random points of an unseen object,
// just inside of its corners and edges, and just past the edges of what is seen in front of it.
#pragma once
#include <cstdint>
#include <glm/vec2.hpp>
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

/// A ray that passes an edge or a corner of the object by a fraction of a pixel: through the gaps
/// and holes that it borders. None if that place is outside of the image.
std::optional<Ray> aimBeside(const RayView& view, const RayView::Placed& placed,
                             const glm::dvec2& pixel_ndc, Random& random);

}  // namespace culld::oracle
