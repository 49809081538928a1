// One frame of method `occluder-volumes`: a few volumes are chosen, then the hierarchy is walked
// and every box held against the frustum and against those volumes that still concern it.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/culler.h"
#include "culling/methods/occluder_volumes_choice.h"
#include "culling/occluders/volume_eye.h"
#include "culling/occluders/volume_occluders.h"
#include "culling/spatial/frustum_test.h"
#include "culling/spatial/wide_bvh.h"

namespace culld {

/// Bit v: volume v may still hide something.
using VolumeMask = std::uint64_t;

struct OccluderVolumesMemory final : ViewState::Memory {
  struct Entry {
    std::uint32_t node;
    PlaneMask planes;
    VolumeMask volumes;
  };
  VolumeChoiceMemory choice;
  std::vector<Entry> stack;
};

class OccluderVolumesWalk {
 public:
  /// REQUIRES: eye.why_not is empty, or options.volumes is 0. Keeps references to all that it is
  /// given.
  OccluderVolumesWalk(const SceneSnapshot& scene, const WideBvh& bvh,
                      const VolumeOccluders& occluders, const Camera& camera, const VolumeEye& eye,
                      const OccluderVolumesOptions& options, const Deadline& deadline,
                      OccluderVolumesMemory& memory);

  /// Appends the objects not proven hidden to answer.visible, in no particular order.
  void run(Answer& answer);

 private:
  void visitNode(const OccluderVolumesMemory::Entry& entry, Answer& answer);
  bool hidden(const SeenBox& box, VolumeMask& volumes, VolumeMask& close);
  bool hiddenByItsOwnBox(const Instance& instance, VolumeMask close);

  const SceneSnapshot& scene_;
  const WideBvh& bvh_;
  const VolumeOccluders& occluders_;
  const VolumeEye& eye_;
  const OccluderVolumesOptions& options_;
  const Deadline& deadline_;
  OccluderVolumesMemory& memory_;
  FrustumTest frustum_;
  ChosenVolumes chosen_;
  CullStats stats_;
};

}  // namespace culld
