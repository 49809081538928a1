#include "culling/methods/frustum.h"

#include <utility>

#include "culling/spatial/frustum_test.h"
#include "culling/spatial/frustum_walk.h"
#include "culling/spatial/wide_bvh.h"

namespace culld {
namespace {

class FrustumCuller final : public Culler {
 public:
  FrustumCuller(SnapshotPtr scene, WideBvh bvh, const Clock& clock)
      : scene_(std::move(scene)), bvh_(std::move(bvh)), clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& /*view*/) const override {
    const auto start = clock_.now();
    Answer answer;
    const FrustumWalkStats walk = appendInFrustum(
        bvh_, FrustumTest(camera, bvh_), Deadline(clock_, start, demand.time), answer.visible);
    const std::size_t found = answer.visible.size();
    const auto always = bvh_.alwaysKept();
    answer.visible.insert(answer.visible.end(), always.begin(), always.end());
    sortIds(answer.visible, scene_->objectCount());

    answer.out_of_budget = walk.out_of_time;
    if (walk.out_of_time) answer.note = "frustum: out of time, undecided objects are kept";
    answer.stats.nodes_visited = walk.nodes_visited;
    answer.stats.tested = walk.tested;
    answer.stats.outside = static_cast<std::uint32_t>(bvh_.liveObjects() - found);
    answer.stats.in_frustum = static_cast<std::uint32_t>(answer.visible.size());
    answer.stats.always_kept = static_cast<std::uint32_t>(always.size());
    answer.stats.time = clock_.now() - start;
    return answer;
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    if (auto fits = WideBvh::fits(*next); !fits) return std::move(fits).error();
    WideBvh bvh = bvh_.edited(*next, changed);
    return std::unique_ptr<Culler>(
        std::make_unique<FrustumCuller>(std::move(next), std::move(bvh), clock_));
  }

  std::size_t preparedBytes() const noexcept override { return bvh_.bytes(); }

 private:
  SnapshotPtr scene_;
  WideBvh bvh_;
  const Clock& clock_;
};

class FrustumMethod final : public Method {
 public:
  MethodInfo info() const noexcept override {
    return {"frustum", "Assarsson, M\u00f6ller 2000 (HVFC)", Guarantee::kConservative, "boxes"};
  }
  Result<void> accepts(const SceneProfile& /*profile*/) const override { return Done{}; }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    if (auto fits = WideBvh::fits(*scene); !fits) return std::move(fits).error();
    WideBvh bvh = WideBvh::build(*scene);
    return std::unique_ptr<Culler>(
        std::make_unique<FrustumCuller>(std::move(scene), std::move(bvh), clock));
  }
};

}  // namespace

const Method& frustumMethod() noexcept {
  static const FrustumMethod method;
  return method;
}

}  // namespace culld
