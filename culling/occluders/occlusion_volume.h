// The space that one convex occluder hides: behind the planes of its faces that turn to the eye,
// and within the planes through the eye and its contour. Open at the back. After M. Bacik 2002,
// "Rendering the Great Outdoors: Fast Occlusion Culling for Outdoor Environments", and the shadow
// frusta of Hudson et al. 1997. Departs from both: margins that make it sound, and it holds for an
// eye that moves (docs/error-model/occlusion-volumes.md).
#pragma once
#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "culling/core/box.h"
#include "culling/core/convex_piece.h"
#include "culling/occluders/volume_eye.h"

namespace culld {

/// What a volume is made from.
struct VolumeOccluder {
  ConvexPiece shape;
  /// Mesh space: of the shape, or of the whole closed surface that a solid shape lies within.
  Box box_mesh;
  /// The shape does not block by itself: it lies within a closed surface that does.
  bool solid = false;
};

/// Inside where normal . x - offset > slack_per_m * reach + slack, `reach` that of what is tested.
struct VolumePlane {
  glm::dvec3 normal;
  double offset = 0.0;
  double slack_per_m = 0.0, slack = 0.0;
  double length = 0.0;  ///< at least that of the normal
  /// For an eye that moves: the contour's edge that the plane turns about, its start and length.
  glm::dvec3 edge{0.0}, start{0.0};
  double edge_length = 0.0;
  double edge_error = 0.0;
};

/// A box or its like relative to VolumeEye::origin_world. Each number is known to 2 units in the
/// last place of `reach`, and none is larger.
struct SeenBox {
  glm::dvec3 low{0.0}, high{0.0};
  double reach = 0.0;
};

struct VolumeSettings {
  bool collapse = true;      ///< one plane for all facing ones
  bool sphere_first = true;  ///< a box's sphere before its corners
};

enum class VolumeVerdict : std::uint8_t {
  kHidden,   ///< surely, all of it
  kMostly,   ///< undecided, but its centre is hidden: a closer look may pay
  kPartly,   ///< undecided
  kOutside,  ///< wholly outside one plane: nothing of it can be found hidden here
};

class OcclusionVolume {
 public:
  /// False: the occluder turns nothing to the eye for certain, a clip plane may cut it, or it is
  /// too complicated. The volume is then of no use. REQUIRES: eye.why_not is empty.
  bool build(const VolumeOccluder& occluder, const std::array<double, 12>& world_from_mesh,
             const VolumeEye& eye, const VolumeSettings& settings);

  /// `planes` grows by the comparisons of a point or a sphere with a plane.
  VolumeVerdict test(const SeenBox& box, std::uint64_t& planes) const noexcept;
  /// Are all points inside? They are known to 2 units of `reach` each.
  bool hidesPoints(std::span<const glm::dvec3> points, double reach,
                   std::uint64_t& planes) const noexcept;

  /// Of the image, about: how large the occluder is on it.
  double share() const noexcept { return share_; }
  std::span<const VolumePlane> planes() const noexcept { return planes_; }
  /// Of the occluder itself.
  const SeenBox& box() const noexcept { return box_; }

 private:
  friend class VolumeBuilder;
  VolumeVerdict testSphere(const SeenBox& box, bool& centre_inside,
                           std::uint64_t& planes) const noexcept;
  bool hidesCorners(const SeenBox& box, std::uint64_t& planes) const noexcept;

  std::vector<VolumePlane> planes_;
  SeenBox box_;
  double radius_m_ = 0.0;  ///< of the eye's motion
  double share_ = 0.0;
  bool sphere_first_ = true;
};

/// The box origin + [low, high]. `origin` is relative to VolumeEye::origin_world and has been
/// rounded once, as the others may have been.
SeenBox seenBox(const glm::dvec3& origin, const glm::dvec3& low, const glm::dvec3& high) noexcept;

/// The eight corners of a mesh's box where its object stands. Returns their reach.
double seenCorners(const Box& box_mesh, const std::array<double, 12>& world_from_mesh,
                   const VolumeEye& eye, std::array<glm::dvec3, 8>& corners) noexcept;

}  // namespace culld
