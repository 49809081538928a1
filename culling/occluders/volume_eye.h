// A camera as occlusion volumes see it: in object space there is no image, only where rays begin,
// how far their beginnings may move, and how near a blocker may be to be certain of not being cut
// away (docs/error-model/occlusion-volumes.md §2).
#pragma once
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <string_view>

#include "culling/core/camera.h"

namespace culld {

struct VolumeEye {
  glm::dvec3 origin_world{0.0};  ///< everything below is relative to it
  bool perspective = true;
  glm::dvec3 along{0.0};     ///< orthographic: direction of all rays, of length 1 up to rounding
  double along_error = 0.0;  ///< of each component
  /// Perspective: the eye may be anywhere within this distance. Parallel rays do not mind.
  double radius_m = 0.0;
  /// Perspective: no clip plane cuts what is farther than this from the eye, on a ray to anything
  /// in the frustum.
  double near_m = 0.0;
  /// Orthographic: a blocker must be on the inner side of both clip planes, by this.
  glm::dvec4 cut_row[2]{};
  double cut_radius_m = 0.0;
  double image = 1.0;        ///< solid angle of the image, or its area (about)
  std::string_view why_not;  ///< if not empty: no volume holds for this camera, and why
};

VolumeEye volumeEye(const Camera& camera) noexcept;

}  // namespace culld
