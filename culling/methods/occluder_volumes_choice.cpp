#include "culling/methods/occluder_volumes_choice.h"

#include <algorithm>
#include <bit>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <numeric>

namespace culld {
namespace {

using Reached = VolumeChoiceMemory::Reached;

constexpr std::uint32_t kTriedPerVolume = 4;   ///< volumes made for each that may be used
constexpr std::uint32_t kTriedPerObject = 16;  ///< of its shapes, the largest
constexpr std::uint32_t kItemsPerLook = 16;    ///< between two looks at the clock

bool smallerFirst(const Reached& a, const Reached& b) { return a.size < b.size; }

/// A bound on the share of the image of anything in the box, about.
double largestShare(const SeenBox& box, const VolumeEye& eye) {
  const glm::dvec3 side = box.high - box.low;
  const double area = 0.25 * std::numbers::pi * glm::dot(side, side) / eye.image;
  if (!eye.perspective) return area;
  const glm::dvec3 away = glm::max(glm::max(box.low, -box.high), glm::dvec3(0.0));
  const double distance2 = glm::dot(away, away);
  return distance2 > 0.0 ? area / distance2 : std::numeric_limits<double>::infinity();
}

class Chooser {
 public:
  Chooser(const SceneSnapshot& scene, const WideBvh& bvh, const VolumeOccluders& occluders,
          const FrustumTest& frustum, const VolumeEye& eye, const OccluderVolumesOptions& options,
          VolumeChoiceMemory& memory)
      : scene_(scene),
        bvh_(bvh),
        occluders_(occluders),
        frustum_(frustum),
        eye_(eye),
        options_(options),
        memory_(memory) {}

  ChosenVolumes run(const Deadline& deadline) {
    const std::uint32_t most = kTriedPerVolume * options_.volumes;
    memory_.queue.clear();
    for (std::uint32_t root = 0; root < bvh_.rootCount(); ++root) {
      push({std::numeric_limits<double>::infinity(), ChildRef::node(root), frustum_.planes()});
    }
    for (std::uint32_t taken = 0; tried_ < most && !memory_.queue.empty(); ++taken) {
      if (taken % kItemsPerLook == 0 && deadline.passed()) break;
      std::pop_heap(memory_.queue.begin(), memory_.queue.end(), smallerFirst);
      const Reached item = memory_.queue.back();
      memory_.queue.pop_back();
      if (item.ref.isNode()) {
        visitNode(item);
      } else {
        tryObject(scene_.instance(item.ref.objectId()), most);
      }
    }
    choose();
    return std::move(chosen_);
  }

 private:
  void push(const Reached& item) {
    memory_.queue.push_back(item);
    std::push_heap(memory_.queue.begin(), memory_.queue.end(), smallerFirst);
  }

  void visitNode(const Reached& item) {
    ++chosen_.nodes_visited;
    const WideNode& node = bvh_.node(item.ref.nodeIndex());
    const LaneVerdicts verdicts = frustum_.test(node, item.planes);
    for (std::uint32_t lanes = verdicts.may_intersect & node.blocking; lanes != 0;
         lanes &= lanes - 1) {
      const auto lane = static_cast<std::size_t>(std::countr_zero(lanes));
      const double share = largestShare(laneBox(node, lane, eye_), eye_);
      if (!(share >= options_.least_share)) continue;
      push({share, node.child[lane], verdicts.planesLeft(lane)});
    }
  }

  void tryObject(const Instance& instance, std::uint32_t most) {
    const std::uint32_t count = std::min(occluders_.countOf(instance.mesh), kTriedPerObject);
    for (std::uint32_t i = 0; i < count && tried_ < most; ++i, ++tried_) {
      if (memory_.found.size() == found_) memory_.found.emplace_back();
      OcclusionVolume& volume = memory_.found[found_];
      const bool made = volume.build(occluders_.occluder(instance.mesh, i),
                                     instance.world_from_mesh, eye_, options_.volume);
      if (made && volume.share() >= options_.least_share) ++found_;
    }
  }

  /// The largest ones, without those that hide behind them.
  void choose() {
    std::vector<std::uint32_t>& order = memory_.order;
    order.resize(found_);
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(), [this](std::uint32_t a, std::uint32_t b) {
      return memory_.found[a].share() > memory_.found[b].share();
    });
    for (const std::uint32_t i : order) {
      const OcclusionVolume& volume = memory_.found[i];
      if (chosen_.volumes.size() == options_.volumes) break;
      if (!options_.drop_hidden || !hidden(volume.box())) chosen_.volumes.push_back(&volume);
    }
  }

  bool hidden(const SeenBox& box) {
    return std::any_of(chosen_.volumes.begin(), chosen_.volumes.end(),
                       [&](const OcclusionVolume* volume) {
                         return volume->test(box, chosen_.plane_tests) == VolumeVerdict::kHidden;
                       });
  }

  const SceneSnapshot& scene_;
  const WideBvh& bvh_;
  const VolumeOccluders& occluders_;
  const FrustumTest& frustum_;
  const VolumeEye& eye_;
  const OccluderVolumesOptions& options_;
  VolumeChoiceMemory& memory_;
  ChosenVolumes chosen_;
  std::uint32_t tried_ = 0;
  std::size_t found_ = 0;
};

}  // namespace

ChosenVolumes chooseVolumes(const SceneSnapshot& scene, const WideBvh& bvh,
                            const VolumeOccluders& occluders, const FrustumTest& frustum,
                            const VolumeEye& eye, const OccluderVolumesOptions& options,
                            const Deadline& deadline, VolumeChoiceMemory& memory) {
  return Chooser(scene, bvh, occluders, frustum, eye, options, memory).run(deadline);
}

SeenBox laneBox(const WideNode& node, std::size_t lane, const VolumeEye& eye) noexcept {
  const auto offset = [&](std::size_t row) { return static_cast<double>(node.offsets[row][lane]); };
  const glm::dvec3 origin(node.origin[0], node.origin[1], node.origin[2]);
  return seenBox(origin - eye.origin_world, {offset(kMinX), offset(kMinY), offset(kMinZ)},
                 {offset(kMaxX), offset(kMaxY), offset(kMaxZ)});
}

}  // namespace culld
