// Whether a pose is within a motion bound of another: then the answer to that one holds for it too.
#pragma once
#include <array>

#include "protocol/messages.h"

namespace culld::client {

struct Pose {
  std::array<double, 3> eye{};
  std::array<double, 9> rotation{};  ///< rows: right, up, back of the camera
};

/// REQUIRES: a camera that can be one (a view matrix without scale or shear).
Pose poseOf(const protocol::Camera& camera);

bool withinBound(const Pose& pose, const Pose& centre, double radius_m, double angle_rad);

}  // namespace culld::client
