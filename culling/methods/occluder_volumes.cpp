#include "culling/methods/occluder_volumes.h"

#include <memory>
#include <string>
#include <utility>

#include "culling/box_answer.h"
#include "culling/methods/occluder_volumes_walk.h"
#include "culling/occluders/volume_occluders.h"
#include "culling/spatial/prepared_boxes.h"

namespace culld {
namespace {

using SharedOccluders = std::shared_ptr<const VolumeOccluders>;

class OccluderVolumesCuller final : public Culler {
 public:
  OccluderVolumesCuller(PreparedBoxes boxes, SharedOccluders occluders,
                        const OccluderVolumesOptions& options, const Clock& clock)
      : boxes_(std::move(boxes)),
        occluders_(std::move(occluders)),
        options_(options),
        clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
    const auto start = clock_.now();
    const Deadline deadline(clock_, start, demand.time);
    const WideBvh& bvh = boxes_.bvh();
    Answer answer;
    const VolumeEye eye = volumeEye(camera);
    OccluderVolumesOptions options = options_;
    if (!eye.why_not.empty()) options.volumes = 0;
    OccluderVolumesWalk(*boxes_.scene(), bvh, *occluders_, camera, eye, options, deadline,
                        view.memory<OccluderVolumesMemory>())
        .run(answer);
    completeAnswer(boxes_, "occluder-volumes", answer);
    if (!eye.why_not.empty()) {
      answer.note = "occluder-volumes: " + std::string(eye.why_not) + ", occlusion is left out";
    }
    answer.stats.time = clock_.now() - start;
    return answer;
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    return around(boxes_.edited(std::move(next), changed), occluders_, options_, clock_);
  }

  std::size_t preparedBytes() const noexcept override {
    return boxes_.bytes() + occluders_->bytes();
  }

  static Result<std::unique_ptr<Culler>> around(Result<PreparedBoxes> boxes,
                                                SharedOccluders occluders,
                                                const OccluderVolumesOptions& options,
                                                const Clock& clock) {
    if (!boxes) return std::move(boxes).error();
    return std::unique_ptr<Culler>(std::make_unique<OccluderVolumesCuller>(
        std::move(boxes).value(), std::move(occluders), options, clock));
  }

 private:
  PreparedBoxes boxes_;
  SharedOccluders occluders_;
  OccluderVolumesOptions options_;
  const Clock& clock_;
};

constexpr Setting kSettings[] = {
    {"hulls", "meshes that are no convex pieces occlude by hulls within their closed parts"},
    {"collapse", "one plane in front of each volume instead of one for each face"},
    {"sphere", "a box's sphere is held against a volume before its corners"},
    {"oriented", "objects that are turned are asked by their mesh's own box too"},
    {"drop-hidden", "occluders that a larger volume hides make no volume"},
    {"least-share", "of the image: smaller occluders make no volume", 0.002, 0.0, 1.0, false},
    {"volumes", "at most, in use in a frame", 32, 1, kMostVolumes}};

OccluderVolumesOptions optionsOf(const SettingValues& values) {
  return {values.on("hulls"),           {values.on("collapse"), values.on("sphere")},
          values.on("drop-hidden"),     values.on("oriented"),
          values.number("least-share"), static_cast<std::uint32_t>(values.number("volumes"))};
}

class OccluderVolumesMethod final : public Method {
 public:
  explicit OccluderVolumesMethod(const SettingValues& values) : options_(optionsOf(values)) {}

  MethodInfo info() const noexcept override {
    return {"occluder-volumes", "Bacik 2002; Hudson et al. 1997", Guarantee::kConservative,
            "triangles"};
  }
  Result<void> accepts(const SceneProfile& /*profile*/) const override { return Done{}; }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    auto occluders = occludersOf(*scene);
    return OccluderVolumesCuller::around(PreparedBoxes::of(std::move(scene)), std::move(occluders),
                                         options_, clock);
  }
  Result<std::unique_ptr<Culler>> prepareBeside(const Culler& sibling, SnapshotPtr scene,
                                                const Clock& clock) const override {
    const PreparedBoxes* lent = boxesOf(sibling);
    if (lent == nullptr) return prepare(std::move(scene), clock);
    return OccluderVolumesCuller::around(*lent, occludersOf(*scene), options_, clock);
  }
  std::span<const Setting> settings() const noexcept override { return kSettings; }
  std::unique_ptr<const Method> with(const SettingValues& values) const override {
    return std::make_unique<const OccluderVolumesMethod>(values);
  }

 private:
  SharedOccluders occludersOf(const SceneSnapshot& scene) const {
    const std::size_t hull_triangles = options_.hulls ? VolumeOccluders::kMostHullTriangles : 0;
    return std::make_shared<const VolumeOccluders>(VolumeOccluders::of(scene, hull_triangles));
  }

  OccluderVolumesOptions options_;
};

}  // namespace

const Method& occluderVolumesMethod() noexcept {
  static const OccluderVolumesMethod method{SettingValues(kSettings)};
  return method;
}

}  // namespace culld
