#include "culling/methods/layers.h"

#include <memory>
#include <utility>

#include "culling/box_answer.h"
#include "culling/methods/layers_frame.h"
#include "culling/spatial/prepared_boxes.h"

namespace culld {
namespace {

class LayersCuller final : public Culler {
 public:
  LayersCuller(PreparedBoxes boxes, std::shared_ptr<const OccluderSet> occluders, SolidGrid grid,
               const LayersOptions& options, const Clock& clock)
      : boxes_(std::move(boxes)),
        occluders_(std::move(occluders)),
        grid_(std::move(grid)),
        options_(options),
        clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
    const auto run = [&](const Deadline& deadline, Answer& answer) -> std::string_view {
      if (!camera.perspective) return "an orthographic camera";
      if (!holdsInMotion(camera)) return "the motion bound turns too far";
      const LayersScene scene{*boxes_.scene(), boxes_.bvh(), *occluders_, grid_};
      LayersFrame(scene, options_, camera, deadline, demand, view.memory<LayersMemory>())
          .run(answer);
      return {};
    };
    return answerBy("layers", boxes_, clock_, camera, demand, run);
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    auto boxes = boxes_.edited(std::move(next), changed);
    if (!boxes) return std::move(boxes).error();
    return std::unique_ptr<Culler>(std::make_unique<LayersCuller>(
        std::move(boxes).value(), occluders_, grid_.edited(changed), options_, clock_));
  }

  std::size_t preparedBytes() const noexcept override {
    return boxes_.bytes() + occluders_->bytes() + grid_.bytes();
  }

 private:
  PreparedBoxes boxes_;
  std::shared_ptr<const OccluderSet> occluders_;
  SolidGrid grid_;
  LayersOptions options_;
  const Clock& clock_;
};

constexpr LayersOptions kStandard{};

constexpr Setting kSettings[] = {
    {"cells", "per object", kStandard.cells_per_object, 0.001, 100.0, false},
    {"solidity", "weight of what a cell blocks; 0: the nearest come first", kStandard.solidity, 0.0,
     1.0, false},
    {"polygons", "drawn per frame at most, pieces or triangles", kStandard.most_polygons, 0.0, 1e7},
    {"triangles", "answered at most where loss is accepted by accept-px; 0: any number",
     kStandard.most_triangles, 0.0, 4e9},
    {"accept-px", "pixels that may be lost where approximate answers are demanded",
     kStandard.accepted_px, 0.0, 1e9, false},
};

class LayersMethod final : public Method {
 public:
  explicit LayersMethod(const LayersOptions& options) : options_(options) {}

  MethodInfo info() const noexcept override {
    return {"layers", "Klosowski, Silva 2000 (PLP), 2001 (cPLP)",
            options_.accepted_px > 0.0 ? Guarantee::kApproximate : Guarantee::kConservative,
            "triangles"};
  }
  std::span<const Setting> settings() const noexcept override { return kSettings; }
  std::unique_ptr<const Method> with(const SettingValues& values) const override {
    return std::make_unique<LayersMethod>(LayersOptions{
        values.number("cells"), values.number("solidity"),
        static_cast<std::uint32_t>(values.number("polygons")),
        static_cast<std::uint32_t>(values.number("triangles")), values.number("accept-px")});
  }
  Result<void> accepts(const SceneProfile& /*profile*/) const override { return Done{}; }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    auto boxes = PreparedBoxes::of(std::move(scene));
    if (!boxes) return std::move(boxes).error();
    const SceneSnapshot& snapshot = *boxes.value().scene();
    auto occluders = std::make_shared<const OccluderSet>(OccluderSet::of(snapshot));
    SolidGrid grid = SolidGrid::of(snapshot, *occluders, options_.cells_per_object);
    return std::unique_ptr<Culler>(std::make_unique<LayersCuller>(
        std::move(boxes).value(), std::move(occluders), std::move(grid), options_, clock));
  }

 private:
  LayersOptions options_;
};

}  // namespace

const Method& layersMethod() noexcept {
  static const LayersMethod method{LayersOptions{}};
  return method;
}

}  // namespace culld
