// Which lanes of a BVH node may a camera see? Planes come from the camera's clip rows, relative to
// its own origin; nodes are moved to that origin in double precision before anything becomes float.
// Conservative: a lane is called outside only with a proof (docs/error-model/frustum.md).
#pragma once
#include <array>
#include <cstdint>

#include "culling/core/camera.h"
#include "culling/spatial/frustum_kernels.h"
#include "culling/spatial/oriented_box.h"
#include "culling/spatial/wide_bvh.h"

namespace culld {

/// Bit p: plane p is still to be tested.
using PlaneMask = std::uint8_t;

struct LaneVerdicts {
  std::uint32_t may_intersect = 0;  ///< live lanes that are not provably outside
  PlaneMask tested = 0;
  std::array<std::uint32_t, kMaxPlanes> inside{};  ///< lanes on the inner side of plane p

  /// Planes that can still cull something below lane l; none: all of it is in the frustum.
  PlaneMask planesLeft(std::size_t lane) const noexcept {
    PlaneMask left = 0;
    for (std::uint32_t p = 0; p < kMaxPlanes; ++p) {
      const bool done = (inside[p] >> lane & 1U) != 0;
      if ((tested >> p & 1U) != 0 && !done) left = static_cast<PlaneMask>(left | 1U << p);
    }
    return left;
  }
};

class FrustumTest {
 public:
  /// For the nodes of `bvh`; looks only at the size of its roots, and keeps no reference.
  FrustumTest(const Camera& camera, const WideBvh& bvh);
  /// For nodes that hold nothing outside `everything`.
  FrustumTest(const Camera& camera, const Box& everything);

  /// Planes that can cull at all. An infinite far plane, for one, is left out.
  PlaneMask planes() const noexcept { return static_cast<PlaneMask>((1U << count_) - 1U); }

  /// GUARANTEES: a lane not in may_intersect holds nothing inside the frustum of any pose within
  /// the camera's motion bound.
  LaneVerdicts test(const WideNode& node, PlaneMask planes) const noexcept;

  /// `planes` without those that can leave out nothing of a lane, as it lies in the octant of the
  /// frustum that is away from them (Assarsson, Moller 2000). `tests` grows by the planes asked.
  PlaneMask inOctant(const WideNode& node, std::size_t lane, PlaneMask planes,
                     std::uint64_t& tests) const noexcept;

  /// Is all of the box surely outside one of `planes`, for every pose? `sphere_first`: the sphere
  /// around it is asked before its sides. `tests` grows by the comparisons with a plane.
  bool outside(const OrientedBox& box, PlaneMask planes, bool sphere_first,
               std::uint64_t& tests) const noexcept;

  /// The planes as `node` sees them, in the order of the bits of `planes`.
  NodePlanes forNode(const WideNode& node, PlaneMask planes) const noexcept;

 private:
  struct Plane {
    glm::dvec3 normal;  ///< of length 1 up to rounding
    double distance;
    std::array<float, 3> normal_float;
    double tiny_slack;  ///< what the smallest floats cannot express
  };
  /// A plane through the middle of the frustum: what is on one side of it cannot be outside the
  /// frustum's plane on the other side alone.
  struct Middle {
    glm::dvec4 row{0.0};
    PlaneMask on_positive = 0, on_negative = 0;  ///< planes that then leave out nothing
  };
  /// `parts`: size of the rows whose sum this is. The plane's bit, none if it can cull nothing.
  PlaneMask add(const glm::dvec4& sum, double parts, double reach);

  std::array<Plane, kMaxPlanes> planes_;
  std::array<Middle, 3> middles_;
  std::uint32_t count_ = 0;
  glm::dvec3 eye_;
  double turn_ = 0.0;   ///< 2 sin(a / 2), rounded up
  double shift_ = 0.0;  ///< planes move outwards by this: the motion bound's radius
};

}  // namespace culld
