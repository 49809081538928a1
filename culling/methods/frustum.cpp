#include "culling/methods/frustum.h"

#include <memory>
#include <utility>

#include "culling/box_answer.h"
#include "culling/spatial/late_boxes.h"

namespace culld {
namespace {

struct FrustumOptions {
  bool masking = true, octants = false, coherence = false, oriented = false, sphere = true;
  std::uint32_t late = 0;
};

struct FrustumMemory final : ViewState::Memory {
  FrustumCoherence coherence;
  bool sceneEdited() override { return true; }  // nothing in it can be wrong
};

class FrustumCuller final : public Culler, public HoldsBoxes {
 public:
  FrustumCuller(LateBoxes boxes, const FrustumOptions& options, const Clock& clock)
      : boxes_(std::move(boxes)), options_(options), clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
    const auto start = clock_.now();
    const WideBvh& bvh = boxes_.boxes().bvh();
    const FrustumParts parts{options_.masking, options_.octants,
                             options_.coherence ? &view.memory<FrustumMemory>().coherence : nullptr,
                             options_.oriented ? boxes_.scene().get() : nullptr, options_.sphere};
    Answer answer;
    FrustumWalkStats walk = appendInFrustum(
        bvh, FrustumTest(camera, bvh), Deadline(clock_, start, demand.time), answer.visible, parts);
    const std::size_t live = boxes_.bringUpToDate(camera, answer.visible, walk);
    countFrustum(walk, live, bvh.alwaysKept().size(), answer);
    completeAnswer(boxes_.boxes(), "frustum", answer);
    answer.stats.time = clock_.now() - start;
    return answer;
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    auto boxes = boxes_.edited(std::move(next), changed);
    if (!boxes) return std::move(boxes).error();
    return std::unique_ptr<Culler>(
        std::make_unique<FrustumCuller>(std::move(boxes).value(), options_, clock_));
  }

  std::size_t preparedBytes() const noexcept override { return boxes_.bytes(); }
  const PreparedBoxes* boxes() const noexcept override {
    return boxes_.waiting().empty() ? &boxes_.boxes() : nullptr;
  }

 private:
  LateBoxes boxes_;
  FrustumOptions options_;
  const Clock& clock_;
};

constexpr Setting kSettings[] = {
    {"masking", "planes that a node is wholly inside of are not asked below it"},
    {"octants", "planes that are across the frustum from a node are not asked", 0.0},
    {"coherence", "planes one by one, that first which left out most in the last frame", 0.0},
    {"oriented", "objects that are turned are asked by their mesh's own box too", 0.0},
    {"sphere", "with oriented: the sphere around that box is asked before it"},
    {"late", "moved objects that wait beside the tree before its volumes are refreshed", 0.0, 0.0,
     4096.0},
};

class FrustumMethod final : public Method {
 public:
  explicit FrustumMethod(const FrustumOptions& options) : options_(options) {}

  MethodInfo info() const noexcept override {
    return {"frustum", "Assarsson, M\u00f6ller 2000 (HVFC)", Guarantee::kConservative, "boxes"};
  }
  std::span<const Setting> settings() const noexcept override { return kSettings; }
  std::unique_ptr<const Method> with(const SettingValues& values) const override {
    return std::make_unique<FrustumMethod>(FrustumOptions{
        values.on("masking"), values.on("octants"), values.on("coherence"), values.on("oriented"),
        values.on("sphere"), static_cast<std::uint32_t>(values.number("late"))});
  }
  Result<void> accepts(const SceneProfile& /*profile*/) const override { return Done{}; }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    auto boxes = PreparedBoxes::of(std::move(scene));
    if (!boxes) return std::move(boxes).error();
    return std::unique_ptr<Culler>(std::make_unique<FrustumCuller>(
        LateBoxes(std::move(boxes).value(), options_.late), options_, clock));
  }

 private:
  FrustumOptions options_;
};

}  // namespace

const Method& frustumMethod() noexcept {
  static const FrustumMethod method{FrustumOptions{}};
  return method;
}

}  // namespace culld
