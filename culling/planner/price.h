// What an answer costs: counted work on the server, and what it makes a thin client draw. Prices
// are stated, not measured at run time, so that the same cameras give the same answers on every
// machine.
#pragma once
#include <chrono>
#include <cstdint>

#include "culling/culler.h"

namespace culld {

/// A phone's browser draws about 300 objects in a 60 Hz frame.
inline constexpr std::chrono::nanoseconds kObjectPrice{50'000};
/// ... and about 100 million triangles a second.
inline constexpr std::chrono::nanoseconds kTrianglePrice{10};

/// Of one object of a scene, its triangles included: the mean, as an answer is not summed up object
/// by object.
inline std::chrono::nanoseconds meanObjectPrice(const SceneProfile& profile) {
  if (profile.objects == 0) return kObjectPrice;
  const std::uint64_t triangles = profile.triangles / profile.objects;
  return kObjectPrice + kTrianglePrice * static_cast<std::int64_t>(triangles);
}

}  // namespace culld
