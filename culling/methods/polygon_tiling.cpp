#include "culling/methods/polygon_tiling.h"

#include <memory>
#include <utility>

#include "culling/methods/polygon_tiling_scene.h"
#include "culling/methods/polygon_tiling_walk.h"
#include "culling/occluders/occluder_set.h"
#include "culling/spatial/frustum_walk.h"

namespace culld {
namespace {

class PolygonTilingCuller final : public Culler {
 public:
  PolygonTilingCuller(PolygonTilingScene scene, std::shared_ptr<const OccluderSet> occluders,
                      std::uint32_t levels, const Clock& clock)
      : scene_(std::move(scene)),
        occluders_(std::move(occluders)),
        levels_(levels),
        clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
    const auto start = clock_.now();
    const Deadline deadline(clock_, start, demand.time);
    Answer answer;
    PolygonTilingWalk walk(scene_, *occluders_, levels_, camera, deadline, demand,
                           view.memory<PolygonTilingMemory>());
    walk.run(answer);
    const auto always = scene_.octree().alwaysKept();
    answer.visible.insert(answer.visible.end(), always.begin(), always.end());
    sortIds(answer.visible, scene_.snapshot().objectCount());
    answer.stats.always_kept = static_cast<std::uint32_t>(always.size());
    if (answer.out_of_budget) {
      answer.note = "polygon-tiling: out of time or work, undecided objects are kept";
    } else if (!walk.occlusion()) {
      answer.note =
          camera.motion.still()
              ? "polygon-tiling: parallel rays almost along an axis, occlusion is left out"
              : "polygon-tiling: a camera with a motion bound, occlusion is left out";
    }
    answer.stats.time = clock_.now() - start;
    return answer;
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    if (auto fits = WideBvh::fits(*next); !fits) return std::move(fits).error();
    return std::unique_ptr<Culler>(std::make_unique<PolygonTilingCuller>(
        scene_.edited(std::move(next), changed), occluders_, levels_, clock_));
  }

  std::size_t preparedBytes() const noexcept override {
    return scene_.bytes() + occluders_->bytes();
  }

 private:
  PolygonTilingScene scene_;
  std::shared_ptr<const OccluderSet> occluders_;
  std::uint32_t levels_;
  const Clock& clock_;
};

constexpr Setting kSettings[] = {
    {"bsp", "orders what is in a cube of the octree by a BSP tree, else it is one group"},
    {"levels", "levels of coverage masks above those of 8 x 8 cells", 15, 0, 15},
    {"leaf", "objects up to which a cube of the octree is not split", 64, 1, 128},
};

class PolygonTilingMethod final : public Method {
 public:
  explicit PolygonTilingMethod(const PolygonTilingParts& parts) : parts_(parts) {}

  MethodInfo info() const noexcept override {
    return {"polygon-tiling", "Greene 1996 (coverage masks)", Guarantee::kConservative,
            "triangles"};
  }
  Result<void> accepts(const SceneProfile& /*profile*/) const override { return Done{}; }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    if (auto fits = WideBvh::fits(*scene); !fits) return std::move(fits).error();
    auto occluders = std::make_shared<const OccluderSet>(OccluderSet::of(*scene));
    return std::unique_ptr<Culler>(
        std::make_unique<PolygonTilingCuller>(PolygonTilingScene::of(std::move(scene), parts_),
                                              std::move(occluders), parts_.levels, clock));
  }
  std::span<const Setting> settings() const noexcept override { return kSettings; }
  std::unique_ptr<const Method> with(const SettingValues& values) const override {
    PolygonTilingParts parts;
    parts.bsp = values.on("bsp");
    parts.levels = static_cast<std::uint32_t>(values.number("levels"));
    parts.leaf_objects = static_cast<std::uint32_t>(values.number("leaf"));
    return std::make_unique<PolygonTilingMethod>(parts);
  }

 private:
  PolygonTilingParts parts_;
};

}  // namespace

const Method& polygonTilingMethod() noexcept {
  static const PolygonTilingMethod method{PolygonTilingParts{}};
  return method;
}

}  // namespace culld
