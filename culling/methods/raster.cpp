#include "culling/methods/raster.h"

#include <memory>
#include <utility>

#include "culling/box_answer.h"
#include "culling/methods/raster_walk.h"
#include "culling/occluders/occluder_set.h"
#include "culling/spatial/prepared_boxes.h"

namespace culld {
namespace {

using SharedOccluders = std::shared_ptr<const OccluderSet>;

class RasterCuller final : public Culler {
 public:
  RasterCuller(PreparedBoxes boxes, SharedOccluders occluders, const Clock& clock)
      : boxes_(std::move(boxes)), occluders_(std::move(occluders)), clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
    const auto run = [&](const Deadline& deadline, Answer& answer) -> std::string_view {
      if (!holdsInMotion(camera)) {
        return camera.perspective ? "the motion bound turns too far"
                                  : "an orthographic camera that turns";
      }
      RasterWalk(*boxes_.scene(), boxes_.bvh(), *occluders_, camera, deadline, demand,
                 view.memory<RasterMemory>())
          .run(answer);
      return {};
    };
    return answerBy("raster", boxes_, clock_, camera, demand, run);
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    return around(boxes_.edited(std::move(next), changed), occluders_, clock_);
  }

  std::size_t preparedBytes() const noexcept override {
    return boxes_.bytes() + occluders_->bytes();
  }

  static Result<std::unique_ptr<Culler>> around(Result<PreparedBoxes> boxes,
                                                SharedOccluders occluders, const Clock& clock) {
    if (!boxes) return std::move(boxes).error();
    return std::unique_ptr<Culler>(
        std::make_unique<RasterCuller>(std::move(boxes).value(), std::move(occluders), clock));
  }

 private:
  PreparedBoxes boxes_;
  SharedOccluders occluders_;
  const Clock& clock_;
};

class RasterMethod final : public Method {
 public:
  MethodInfo info() const noexcept override {
    return {"raster", "culld; walk after Greene 1993", Guarantee::kConservative, "triangles"};
  }
  Result<void> accepts(const SceneProfile& /*profile*/) const override { return Done{}; }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    auto occluders = std::make_shared<const OccluderSet>(OccluderSet::of(*scene));
    return RasterCuller::around(PreparedBoxes::of(std::move(scene)), std::move(occluders), clock);
  }
  Result<std::unique_ptr<Culler>> prepareBeside(const Culler& sibling, SnapshotPtr scene,
                                                const Clock& clock) const override {
    const PreparedBoxes* lent = boxesOf(sibling);
    if (lent == nullptr) return prepare(std::move(scene), clock);
    auto occluders = std::make_shared<const OccluderSet>(OccluderSet::of(*scene));
    return RasterCuller::around(*lent, std::move(occluders), clock);
  }
};

}  // namespace

const Method& rasterMethod() noexcept {
  static const RasterMethod method;
  return method;
}

}  // namespace culld
