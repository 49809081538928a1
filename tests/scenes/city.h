// The built-in sample city: streets in blocks, buildings with floors and furniture, trees, cars,
// hills around it. Metres, y up, streets at y = 0.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/scenes/camera_spec.h"
#include "tests/scenes/model.h"

namespace culld::scenes {

struct City {
  Model model;
  /// A fly-through: a walk along streets at 1.7 m that turns corners, a climb above a crossing, an
  /// overview. Never inside solid geometry.
  std::vector<CameraSpec> cameras;
};

struct CityOptions {
  std::uint64_t seed = 1;
  std::uint32_t objects = 120'000;  ///< exactly this many from 1 000 on; fewer give a small town
  std::uint32_t frames = 60;
};

City generateCity(const CityOptions& options);

}  // namespace culld::scenes
