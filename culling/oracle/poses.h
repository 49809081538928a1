// Poses within a camera's motion bound, the extreme ones first: truth about a camera that moves is
// what any of them sees.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/core/camera.h"

namespace culld::oracle {

/// The camera's own pose, then `further` others within its motion bound; each without a bound. Only
/// its own if it is still. First come moves to the ball's surface, right, left, up, down, ahead and
/// back, each turned the same way by the whole angle (rolled, ahead and back); then random ones:
/// every other eye on the surface, two turns of three by the whole angle.
/// GUARANTEES: the poses lie within the bound, rounding included. Equal inputs, equal poses.
std::vector<Camera> posesWithin(const Camera& camera, std::uint32_t further, std::uint64_t seed);

}  // namespace culld::oracle
