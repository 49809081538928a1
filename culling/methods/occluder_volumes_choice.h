// Which occluders of a scene are worth a volume in this frame: few, large on the image, and none
// that another one hides (Bacik 2002; Hudson et al. 1997).
#pragma once
#include <cstdint>
#include <vector>

#include "culling/culler.h"
#include "culling/occluders/occlusion_volume.h"
#include "culling/occluders/volume_occluders.h"
#include "culling/spatial/frustum_test.h"
#include "culling/spatial/wide_bvh.h"

namespace culld {

/// The published parts, each on its own. None changes the promise.
struct OccluderVolumesOptions {
  bool hulls;  ///< besides convex pieces
  VolumeSettings volume;
  bool drop_hidden;       ///< occluders that a larger volume hides make no volume
  bool oriented;          ///< objects are asked by the box of their mesh too
  double least_share;     ///< of the image: smaller occluders make no volume
  std::uint32_t volumes;  ///< at most, in use; none: the frustum's answer
};

inline constexpr std::uint32_t kMostVolumes = 64;

/// Buffers kept from frame to frame for their memory only: nothing in them is read again.
struct VolumeChoiceMemory {
  struct Reached {
    double size;  ///< nothing below it is larger on the image
    ChildRef ref;
    PlaneMask planes;
  };
  std::vector<Reached> queue;          ///< a heap, largest on top
  std::vector<OcclusionVolume> found;  ///< a few of them in use
  std::vector<std::uint32_t> order;
};

struct ChosenVolumes {
  std::vector<const OcclusionVolume*> volumes;  ///< largest first; live as long as the memory
  std::uint32_t nodes_visited = 0;
  std::uint64_t plane_tests = 0;
};

/// COST: bounded by options.volumes, not by the scene, but for its depth.
ChosenVolumes chooseVolumes(const SceneSnapshot& scene, const WideBvh& bvh,
                            const VolumeOccluders& occluders, const FrustumTest& frustum,
                            const VolumeEye& eye, const OccluderVolumesOptions& options,
                            const Deadline& deadline, VolumeChoiceMemory& memory);

/// The box of a lane relative to the eye.
SeenBox laneBox(const WideNode& node, std::size_t lane, const VolumeEye& eye) noexcept;

}  // namespace culld
