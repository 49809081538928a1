// Owning handles of Embree objects.
#pragma once
#include <embree3/rtcore.h>

#include <glm/vec3.hpp>
#include <memory>
#include <type_traits>

namespace culld::oracle {

struct DeviceRelease {
  void operator()(RTCDevice device) const noexcept { rtcReleaseDevice(device); }
};
struct SceneRelease {
  void operator()(RTCScene scene) const noexcept { rtcReleaseScene(scene); }
};
using DeviceHandle = std::unique_ptr<std::remove_pointer_t<RTCDevice>, DeviceRelease>;
using SceneHandle = std::unique_ptr<std::remove_pointer_t<RTCScene>, SceneRelease>;

/// A committed scene of `count` primitives that know their own boxes and hits. `user` is handed to
/// both functions. Null if Embree ran out of memory.
SceneHandle makePrimitives(RTCDevice device, unsigned count, void* user, RTCBoundsFunction bounds,
                           RTCIntersectFunctionN intersect);

/// May Embree be asked to walk along this ray? Of numbers that are none, or near the end of float's
/// range, it makes an assertion that fails.
bool castable(const RTCRay& ray);

/// REQUIRES: a box with room for the rounding to float.
void setBounds(RTCBounds& out, const glm::dvec3& low, const glm::dvec3& high);

}  // namespace culld::oracle
