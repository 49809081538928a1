// Depth complexity, measured: how many surfaces lie behind each other in each pixel. Where it is
// high, much is hidden and occlusion culling can pay; where it is near 1 nothing can. (The number
// of polygons that would be seen if all of them were transparent.)
#pragma once
#include <cstdint>
#include <vector>

#include "culling/core/camera.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

struct DepthComplexity {
  std::uint32_t width_px = 0, height_px = 0;
  std::vector<std::uint32_t> surfaces;  ///< per pixel, row by row from the top

  double mean() const noexcept;  ///< over all pixels, those without a surface too
  std::uint32_t most() const noexcept;
  /// The least number that this share of the pixels does not exceed.
  std::uint32_t percentile(double share) const;
  /// Pixels by their number of surfaces: [0] have none.
  std::vector<std::uint64_t> histogram() const;
};

/// Counts the triangles that the ray through each pixel's centre meets between the clip planes,
/// from whichever side, blocking or not. An edge that two triangles share counts once. Objects
/// without a bound count where they are at rest.
/// COST: O(triangles of objects in the frustum + pixels that they cover); about 50 ns a triangle.
DepthComplexity depthComplexity(const SceneSnapshot& scene, const Camera& camera,
                                std::uint32_t width_px, std::uint32_t height_px);

}  // namespace culld
