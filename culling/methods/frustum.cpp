#include "culling/methods/frustum.h"

#include <utility>

#include "culling/box_answer.h"
#include "culling/spatial/prepared_boxes.h"

namespace culld {
namespace {

class FrustumCuller final : public Culler, public HoldsBoxes {
 public:
  FrustumCuller(PreparedBoxes boxes, const Clock& clock)
      : boxes_(std::move(boxes)), clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& /*view*/) const override {
    const auto start = clock_.now();
    Answer answer;
    answerFrustum(boxes_, camera, Deadline(clock_, start, demand.time), "", answer);
    completeAnswer(boxes_, "frustum", answer);
    answer.stats.time = clock_.now() - start;
    return answer;
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    return around(boxes_.edited(std::move(next), changed), clock_);
  }

  std::size_t preparedBytes() const noexcept override { return boxes_.bytes(); }
  const PreparedBoxes& boxes() const noexcept override { return boxes_; }

  static Result<std::unique_ptr<Culler>> around(Result<PreparedBoxes> boxes, const Clock& clock) {
    if (!boxes) return std::move(boxes).error();
    return std::unique_ptr<Culler>(
        std::make_unique<FrustumCuller>(std::move(boxes).value(), clock));
  }

 private:
  PreparedBoxes boxes_;
  const Clock& clock_;
};

class FrustumMethod final : public Method {
 public:
  MethodInfo info() const noexcept override {
    return {"frustum", "Assarsson, M\u00f6ller 2000 (HVFC)", Guarantee::kConservative, "boxes"};
  }
  Result<void> accepts(const SceneProfile& /*profile*/) const override { return Done{}; }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    return FrustumCuller::around(PreparedBoxes::of(std::move(scene)), clock);
  }
};

}  // namespace

const Method& frustumMethod() noexcept {
  static const FrustumMethod method;
  return method;
}

}  // namespace culld
