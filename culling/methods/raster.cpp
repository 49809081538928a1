#include "culling/methods/raster.h"

#include <utility>

#include "culling/methods/raster_walk.h"
#include "culling/spatial/frustum_test.h"
#include "culling/spatial/frustum_walk.h"
#include "culling/spatial/wide_bvh.h"

namespace culld {
namespace {

class RasterCuller final : public Culler {
 public:
  RasterCuller(SnapshotPtr scene, WideBvh bvh, const Clock& clock)
      : scene_(std::move(scene)), bvh_(std::move(bvh)), clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
    const auto start = clock_.now();
    const Deadline deadline(clock_, start, demand.time);
    Answer answer;
    if (camera.motion.still()) {
      RasterWalk(*scene_, bvh_, camera, deadline, view.memory<RasterMemory>()).run(answer);
    } else {
      cullFrustumOnly(camera, deadline, answer);
    }
    const auto always = bvh_.alwaysKept();
    answer.visible.insert(answer.visible.end(), always.begin(), always.end());
    sortIds(answer.visible, scene_->objectCount());
    answer.stats.always_kept = static_cast<std::uint32_t>(always.size());
    if (answer.out_of_budget) answer.note = "raster: out of time, undecided objects are kept";
    answer.stats.time = clock_.now() - start;
    return answer;
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    if (auto fits = WideBvh::fits(*next); !fits) return std::move(fits).error();
    WideBvh bvh = bvh_.edited(*next, changed);
    return std::unique_ptr<Culler>(
        std::make_unique<RasterCuller>(std::move(next), std::move(bvh), clock_));
  }

  std::size_t preparedBytes() const noexcept override { return bvh_.bytes(); }

 private:
  /// What is drawn for one eye proves nothing for another; the frustum widens, occlusion does not.
  void cullFrustumOnly(const Camera& camera, const Deadline& deadline, Answer& answer) const {
    const FrustumWalkStats walk =
        appendInFrustum(bvh_, FrustumTest(camera, bvh_), deadline, answer.visible);
    answer.stats.nodes_visited = walk.nodes_visited;
    answer.stats.tested = walk.tested;
    answer.stats.outside = static_cast<std::uint32_t>(bvh_.liveObjects() - answer.visible.size());
    answer.out_of_budget = walk.out_of_time;
    answer.note = "raster: the request has a motion bound, occlusion is left out";
  }

  SnapshotPtr scene_;
  WideBvh bvh_;
  const Clock& clock_;
};

class RasterMethod final : public Method {
 public:
  MethodInfo info() const noexcept override {
    return {"raster", "culld; walk after Greene 1993", Guarantee::kConservative, "triangles"};
  }
  Result<void> accepts(const SceneProfile& /*profile*/) const override { return Done{}; }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    if (auto fits = WideBvh::fits(*scene); !fits) return std::move(fits).error();
    WideBvh bvh = WideBvh::build(*scene);
    return std::unique_ptr<Culler>(
        std::make_unique<RasterCuller>(std::move(scene), std::move(bvh), clock));
  }
};

}  // namespace

const Method& rasterMethod() noexcept {
  static const RasterMethod method;
  return method;
}

}  // namespace culld
