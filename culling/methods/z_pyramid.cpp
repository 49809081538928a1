#include "culling/methods/z_pyramid.h"

#include <memory>
#include <utility>

#include "culling/methods/z_pyramid_walk.h"
#include "culling/occluders/occluder_set.h"
#include "culling/raster/cell_view.h"
#include "culling/spatial/frustum_walk.h"
#include "culling/spatial/octree.h"

namespace culld {
namespace {

class ZPyramidCuller final : public Culler {
 public:
  ZPyramidCuller(SnapshotPtr scene, Octree octree, std::shared_ptr<const OccluderSet> occluders,
                 const ZPyramidParts& parts, const Clock& clock)
      : scene_(std::move(scene)),
        octree_(std::move(octree)),
        occluders_(std::move(occluders)),
        parts_(parts),
        clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
    const auto start = clock_.now();
    const Deadline deadline(clock_, start, demand.time);
    Answer answer;
    ZPyramidWalk(*scene_, octree_, *occluders_, parts_, camera, deadline, demand,
                 view.memory<ZPyramidMemory>())
        .run(answer);
    const auto always = octree_.alwaysKept();
    answer.visible.insert(answer.visible.end(), always.begin(), always.end());
    sortIds(answer.visible, scene_->objectCount());
    answer.stats.always_kept = static_cast<std::uint32_t>(always.size());
    if (answer.out_of_budget) {
      answer.note = "z-pyramid: out of time or work, undecided objects are kept";
    } else if (!holdsInMotion(camera)) {
      answer.note = "z-pyramid: the camera may turn too far, occlusion is left out";
    }
    answer.stats.time = clock_.now() - start;
    return answer;
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    if (auto fits = WideBvh::fits(*next); !fits) return std::move(fits).error();
    Octree octree = octree_.edited(*scene_, *next, changed);
    return std::unique_ptr<Culler>(std::make_unique<ZPyramidCuller>(
        std::move(next), std::move(octree), occluders_, parts_, clock_));
  }

  std::size_t preparedBytes() const noexcept override {
    return octree_.bytes() + occluders_->bytes();
  }

 private:
  SnapshotPtr scene_;
  Octree octree_;
  std::shared_ptr<const OccluderSet> occluders_;
  ZPyramidParts parts_;
  const Clock& clock_;
};

constexpr Setting kSettings[] = {
    {"coherence", "draws what the last frame found visible before all else"},
    {"faces", "asks boxes by their front faces too, not by their rectangle alone"},
    {"levels", "levels of the pyramid above the Z-buffer that are used", 16, 0, 16},
    {"incremental", "keeps the pyramid up to date with each object drawn, else makes it anew"},
    {"small", "share of an octant's edge below which an object goes into all octants it touches",
     0.5, 0.0, 1.0, false},
    {"leaf", "objects up to which a cube of the octree is not split", 32, 1, 256},
};

class ZPyramidMethod final : public Method {
 public:
  explicit ZPyramidMethod(const ZPyramidParts& parts) : parts_(parts) {}

  MethodInfo info() const noexcept override {
    return {"z-pyramid", "Greene, Kass, Miller 1993 (hierarchical visibility)",
            Guarantee::kConservative, "triangles"};
  }
  Result<void> accepts(const SceneProfile& /*profile*/) const override { return Done{}; }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    if (auto fits = WideBvh::fits(*scene); !fits) return std::move(fits).error();
    auto occluders = std::make_shared<const OccluderSet>(OccluderSet::of(*scene));
    Octree octree = Octree::of(*scene, parts_.octree);
    return std::unique_ptr<Culler>(std::make_unique<ZPyramidCuller>(
        std::move(scene), std::move(octree), std::move(occluders), parts_, clock));
  }
  std::span<const Setting> settings() const noexcept override { return kSettings; }
  std::unique_ptr<const Method> with(const SettingValues& values) const override {
    ZPyramidParts parts;
    parts.coherence = values.on("coherence");
    parts.faces = values.on("faces");
    parts.levels = static_cast<std::uint32_t>(values.number("levels"));
    parts.incremental = values.on("incremental");
    parts.octree.small_share = values.number("small");
    parts.octree.leaf_objects = static_cast<std::uint32_t>(values.number("leaf"));
    return std::make_unique<ZPyramidMethod>(parts);
  }

 private:
  ZPyramidParts parts_;
};

}  // namespace

const Method& zPyramidMethod() noexcept {
  static const ZPyramidMethod method{ZPyramidParts{}};
  return method;
}

}  // namespace culld
