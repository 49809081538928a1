// The price of an object of a scene, from the prices of core/prices.h.
#pragma once
#include <chrono>
#include <cstdint>

#include "culling/core/prices.h"
#include "culling/culler.h"

namespace culld {

/// Of one object of a scene, its triangles included: the mean, as an answer is not summed up object
/// by object.
inline std::chrono::nanoseconds meanObjectPrice(const SceneProfile& profile) {
  if (profile.objects == 0) return kObjectPrice;
  const std::uint64_t triangles = profile.triangles / profile.objects;
  return kObjectPrice + kTrianglePrice * static_cast<std::int64_t>(triangles);
}

}  // namespace culld
