// A camera as one object's mesh sees it: facing is asked where triangles are exact, in the mesh's
// own coordinates, and the eye is moved there. A matrix that mirrors needs no care: the side that a
// renderer calls the front is the same side of the mesh (docs/error-model/backface-clusters.md §1).
#pragma once
#include <array>
#include <glm/vec3.hpp>
#include <optional>

#include "culling/occluders/volume_eye.h"

namespace culld {

struct MeshEye {
  /// Where the eye is; of parallel rays the direction to it, of any length.
  glm::dvec3 at{0.0};
  double radius = 0.0;  ///< all eyes (directions) of the motion bound are within this distance
  bool parallel = false;
};

/// None if the matrix is flat, or so nearly flat that the eye's place in the mesh is not known
/// well. REQUIRES: parallel rays only of a camera that does not turn.
std::optional<MeshEye> meshEye(const std::array<double, 12>& world_from_mesh,
                               const VolumeEye& eye) noexcept;

}  // namespace culld
