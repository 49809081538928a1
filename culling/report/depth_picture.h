// A picture of depth complexity: how many surfaces lie behind each other in each pixel.
#pragma once
#include <cstdint>
#include <span>
#include <string>

#include "culling/core/result.h"

namespace culld {

struct DepthToDraw {
  std::span<const std::uint32_t> surfaces;  ///< per pixel, row by row from the top
  std::uint32_t width_px = 0, height_px = 0;
  std::string title;  ///< e.g. "city.glb, camera 0"
};

/// From dark for none over blue and green to yellow for the most, by doublings, with a legend.
/// REQUIRES: a count for each pixel. ERROR: kIo naming the path.
Result<void> drawDepth(const DepthToDraw& depth, const std::string& path_png);

}  // namespace culld
