// The fly-through of the sample city.
#pragma once
#include <cstdint>
#include <vector>

#include "tests/scenes/camera_spec.h"

namespace culld::scenes {

/// The city is centred on the origin; its streets run along the rims of its blocks.
struct CityExtent {
  std::uint32_t columns = 1, rows = 1;  ///< blocks along x and z
  double highest_m = 0.0;               ///< no building reaches above
};

/// Three fifths walk, one fifth climbs, the rest looks down from above the highest roof.
std::vector<CameraSpec> cityCameras(const CityExtent& city, std::uint32_t frames);

}  // namespace culld::scenes
