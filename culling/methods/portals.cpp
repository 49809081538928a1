#include "culling/methods/portals.h"

#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "culling/box_answer.h"
#include "culling/methods/portals_frame.h"
#include "culling/occluders/solid_occluders.h"
#include "culling/occluders/volume_eye.h"
#include "culling/raster/cell_view.h"
#include "culling/spatial/prepared_boxes.h"

namespace culld {
namespace {

constexpr Setting kSettings[] = {
    {"walls", "voxels are cut along the walls of a scene's solids; off: evenly"},
    {"boxes", "solid boxes that are drawn in a frame, at most", 512, 0, 4096},
};

struct PortalsOptions {
  SolidLimits solids;
  std::uint32_t most_boxes;
};

PortalsOptions optionsOf(const SettingValues& values) {
  PortalsOptions options{{}, static_cast<std::uint32_t>(values.number("boxes"))};
  if (!values.on("walls")) options.solids.voxels.most_wall_planes = 0;
  return options;
}

/// Empty if the solids hold for every pose within the camera's motion bound; else why not.
std::string_view whyNot(const SolidOccluders& solids, const Camera& camera) {
  if (solids.size() == 0) return "nothing in this scene is solid";
  if (!camera.perspective) return "an orthographic camera";
  if (!holdsInMotion(camera)) return "the motion bound turns too far";
  const VolumeEye eye = volumeEye(camera);
  if (!eye.why_not.empty()) return eye.why_not;
  const glm::dvec3 reach((eye.near_m + eye.radius_m) * (1.0 + 1e-9));
  if (solids.clear({eye.origin_world - reach, eye.origin_world + reach})) return {};
  return "the eye is within a solid or too near to one";
}

class PortalsCuller final : public Culler {
 public:
  PortalsCuller(PreparedBoxes boxes, SolidOccluders solids, std::uint32_t most_boxes,
                const Clock& clock)
      : boxes_(std::move(boxes)),
        solids_(std::move(solids)),
        most_boxes_(most_boxes),
        clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
    const auto run = [&](const Deadline& deadline, Answer& answer) -> std::string_view {
      const std::string_view why_not = whyNot(solids_, camera);
      if (!why_not.empty()) return why_not;
      PortalsFrame(boxes_.bvh(), solids_, most_boxes_, camera, deadline, demand,
                   view.memory<PortalsMemory>())
          .run(answer);
      return {};
    };
    return answerBy("portals", boxes_, clock_, camera, demand, run);
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    return around(boxes_.edited(std::move(next), changed), solids_.without(changed), most_boxes_,
                  clock_);
  }

  std::size_t preparedBytes() const noexcept override { return boxes_.bytes() + solids_.bytes(); }

  static Result<std::unique_ptr<Culler>> around(Result<PreparedBoxes> boxes,
                                                Result<SolidOccluders> solids,
                                                std::uint32_t most_boxes, const Clock& clock) {
    if (!boxes) return std::move(boxes).error();
    if (!solids) return std::move(solids).error();
    return std::unique_ptr<Culler>(std::make_unique<PortalsCuller>(
        std::move(boxes).value(), std::move(solids).value(), most_boxes, clock));
  }

 private:
  PreparedBoxes boxes_;
  SolidOccluders solids_;
  std::uint32_t most_boxes_;
  const Clock& clock_;
};

class PortalsMethod final : public Method {
 public:
  explicit PortalsMethod(const SettingValues& values) : options_(optionsOf(values)) {}

  MethodInfo info() const noexcept override {
    return {"portals", "Silvennoinen et al. 2011 (Umbra 3), made sound", Guarantee::kConservative,
            "closed surfaces thicker than a voxel"};
  }
  Result<void> accepts(const SceneProfile& profile) const override {
    if (profile.blocking_triangles != 0) return Done{};
    return Error{ErrorCode::kUnsupported, "portals: nothing in this scene blocks"};
  }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    Result<SolidOccluders> solids = SolidOccluders::of(*scene, options_.solids);
    return PortalsCuller::around(PreparedBoxes::of(std::move(scene)), std::move(solids),
                                 options_.most_boxes, clock);
  }
  Result<std::unique_ptr<Culler>> prepareBeside(const Culler& sibling, SnapshotPtr scene,
                                                const Clock& clock) const override {
    const PreparedBoxes* lent = boxesOf(sibling);
    if (lent == nullptr) return prepare(std::move(scene), clock);
    return PortalsCuller::around(*lent, SolidOccluders::of(*scene, options_.solids),
                                 options_.most_boxes, clock);
  }
  std::span<const Setting> settings() const noexcept override { return kSettings; }
  std::unique_ptr<const Method> with(const SettingValues& values) const override {
    return std::make_unique<const PortalsMethod>(values);
  }

 private:
  PortalsOptions options_;
};

}  // namespace

const Method& portalsMethod() noexcept {
  static const PortalsMethod method{SettingValues(kSettings)};
  return method;
}

}  // namespace culld
