#include "culling/methods/occluder_volumes_walk.h"

#include <array>
#include <bit>

#include "culling/spatial/frustum_walk.h"
#include "culling/spatial/oriented_box.h"

namespace culld {
namespace {

constexpr std::uint32_t kNodesPerLook = 16;  ///< between two looks at the clock
// Nanoseconds of counted work, measured (docs/methods/occluder-volumes.md).
constexpr std::uint64_t kNodeNs = 240, kPlaneTestNs = 6;

}  // namespace

OccluderVolumesWalk::OccluderVolumesWalk(const SceneSnapshot& scene, const WideBvh& bvh,
                                         const VolumeOccluders& occluders, const Camera& camera,
                                         const VolumeEye& eye,
                                         const OccluderVolumesOptions& options,
                                         const Deadline& deadline, OccluderVolumesMemory& memory)
    : scene_(scene),
      bvh_(bvh),
      occluders_(occluders),
      eye_(eye),
      options_(options),
      deadline_(deadline),
      memory_(memory),
      frustum_(camera, bvh) {}

void OccluderVolumesWalk::run(Answer& answer) {
  chosen_ =
      chooseVolumes(scene_, bvh_, occluders_, frustum_, eye_, options_, deadline_, memory_.choice);
  stats_.occluders_drawn = static_cast<std::uint32_t>(chosen_.volumes.size());
  stats_.nodes_visited = chosen_.nodes_visited;
  stats_.plane_tests = chosen_.plane_tests;
  const VolumeMask all = chosen_.volumes.size() == kMostVolumes
                             ? ~VolumeMask{0}
                             : (VolumeMask{1} << chosen_.volumes.size()) - 1;
  memory_.stack.clear();
  for (auto root = static_cast<std::uint32_t>(bvh_.rootCount()); root-- > 0;)
    memory_.stack.push_back({root, frustum_.planes(), all});
  for (std::uint32_t taken = 0; !memory_.stack.empty(); ++taken) {
    if (taken % kNodesPerLook == 0 && deadline_.passed()) break;
    const OccluderVolumesMemory::Entry entry = memory_.stack.back();
    memory_.stack.pop_back();
    visitNode(entry, answer);
  }
  answer.out_of_budget = !memory_.stack.empty();
  for (const OccluderVolumesMemory::Entry& entry : memory_.stack)
    bvh_.appendObjects(entry.node, answer.visible);
  if (answer.out_of_budget) stats_.in_frustum = 0;
  stats_.work =
      std::chrono::nanoseconds(kNodeNs * stats_.nodes_visited + kPlaneTestNs * stats_.plane_tests);
  answer.stats = stats_;
}

void OccluderVolumesWalk::visitNode(const OccluderVolumesMemory::Entry& entry, Answer& answer) {
  const WideNode& node = bvh_.node(entry.node);
  if (entry.planes == 0 && entry.volumes == 0) {  // nothing can leave out anything below
    stats_.in_frustum += node.live_objects;
    bvh_.appendObjects(entry.node, answer.visible);
    return;
  }
  ++stats_.nodes_visited;
  const LaneVerdicts verdicts = frustum_.test(node, entry.planes);
  for (std::uint32_t lanes = node.live; lanes != 0; lanes &= lanes - 1) {
    const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
    const ChildRef child = node.child[lane];
    if (child.isObject()) ++stats_.tested;
    if ((verdicts.may_intersect >> lane & 1U) == 0) {
      if (child.isObject()) ++stats_.outside;
      continue;
    }
    VolumeMask volumes = entry.volumes, close = 0;
    const bool out = volumes != 0 && hidden(laneBox(node, lane, eye_), volumes, close);
    if (child.isNode()) {
      const PlaneMask planes = verdicts.planesLeft(lane);
      if (out) {
        stats_.in_frustum += countInFrustum(bvh_, frustum_, child.nodeIndex(), planes);
      } else {
        memory_.stack.push_back({child.nodeIndex(), planes, volumes});
      }
      continue;
    }
    ++stats_.in_frustum;
    if (out || hiddenByItsOwnBox(scene_.instance(child.objectId()), close)) {
      ++stats_.occluded;
    } else {
      answer.visible.push_back(child.objectId());
    }
  }
}

/// Clears those of `volumes` that cannot hide anything in the box; sets in `close` those that
/// nearly hide it.
bool OccluderVolumesWalk::hidden(const SeenBox& box, VolumeMask& volumes, VolumeMask& close) {
  for (VolumeMask left = volumes; left != 0; left &= left - 1) {
    const auto v = static_cast<std::size_t>(std::countr_zero(left));
    const VolumeMask bit = VolumeMask{1} << v;
    switch (chosen_.volumes[v]->test(box, stats_.plane_tests)) {
      case VolumeVerdict::kHidden:
        return true;
      case VolumeVerdict::kMostly:
        close |= bit;
        break;
      case VolumeVerdict::kPartly:
        break;
      case VolumeVerdict::kOutside:
        volumes &= ~bit;
    }
  }
  return false;
}

/// The box of the object's mesh as it stands there, tighter than its bounds if it is turned.
bool OccluderVolumesWalk::hiddenByItsOwnBox(const Instance& instance, VolumeMask close) {
  if (close == 0 || !options_.oriented || !turned(instance.world_from_mesh)) return false;
  std::array<glm::dvec3, 8> corners;
  const double reach =
      seenCorners(scene_.mesh(instance.mesh).bounds, instance.world_from_mesh, eye_, corners);
  for (VolumeMask left = close; left != 0; left &= left - 1) {
    const OcclusionVolume& volume =
        *chosen_.volumes[static_cast<std::size_t>(std::countr_zero(left))];
    if (volume.hidesPoints(corners, reach, stats_.plane_tests)) return true;
  }
  return false;
}

}  // namespace culld
