#include "culling/methods/occlusion_map.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "culling/box_answer.h"
#include "culling/methods/occlusion_map_frame.h"
#include "culling/spatial/prepared_boxes.h"

namespace culld {
namespace {

/// What no edit changes: meshes.
struct MapMeshes {
  OccluderSet occluders;
  std::vector<std::uint8_t> see_through;  ///< by mesh
  bool all_block = true;
};

bool seeThrough(const Mesh& mesh) {
  return mesh.blocking_triangles != mesh.triangles.size() || mesh.points_and_lines != 0;
}

std::shared_ptr<const MapMeshes> meshesOf(const SceneSnapshot& scene) {
  auto meshes = std::make_shared<MapMeshes>();
  meshes->occluders = OccluderSet::of(scene);
  for (MeshId id = 0; id < scene.meshCount(); ++id) {
    const bool open = seeThrough(scene.mesh(id));
    meshes->see_through.push_back(open ? 1 : 0);
    meshes->all_block = meshes->all_block && !open;
  }
  return meshes;
}

class OcclusionMapCuller final : public Culler {
 public:
  OcclusionMapCuller(PreparedBoxes boxes, std::shared_ptr<const MapMeshes> meshes,
                     OccluderDatabase database, const OcclusionMapOptions& options,
                     const Clock& clock)
      : boxes_(std::move(boxes)),
        meshes_(std::move(meshes)),
        database_(std::move(database)),
        options_(options),
        clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
    const auto run = [&](const Deadline& deadline, Answer& answer) -> std::string_view {
      if (!holdsInMotion(camera)) return "no one image holds for the motion bound";
      const OcclusionMapScene scene{*boxes_.scene(), boxes_.bvh(),         meshes_->occluders,
                                    database_,       meshes_->see_through, meshes_->all_block};
      OcclusionMapFrame(scene, options_, camera, deadline, demand,
                        view.memory<OcclusionMapMemory>())
          .run(answer);
      return {};
    };
    return answerBy("occlusion-map", boxes_, clock_, camera, demand, run);
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    auto boxes = boxes_.edited(std::move(next), changed);
    if (!boxes) return std::move(boxes).error();
    OccluderDatabase database =
        database_.edited(*boxes.value().scene(), boxes.value().bvh(), meshes_->occluders, changed);
    return std::unique_ptr<Culler>(std::make_unique<OcclusionMapCuller>(
        std::move(boxes).value(), meshes_, std::move(database), options_, clock_));
  }

  std::size_t preparedBytes() const noexcept override {
    return boxes_.bytes() + meshes_->occluders.bytes() + meshes_->see_through.capacity() +
           database_.bytes();
  }

 private:
  PreparedBoxes boxes_;
  std::shared_ptr<const MapMeshes> meshes_;
  OccluderDatabase database_;
  OcclusionMapOptions options_;
  const Clock& clock_;
};

constexpr OcclusionMapOptions kStandard{};

constexpr Setting kSettings[] = {
    {"least-size", "occluders: largest side of the box, share of the median",
     kStandard.database.least_size, 0.0, 1e3, false},
    {"most-polygons", "occluders: pieces or triangles of one, 0: any number",
     kStandard.database.most_polygons, 0.0, 1e6},
    {"least-fill", "occluders: blocking area, share of the surface of the box",
     kStandard.database.least_fill, 0.0, 1.0, false},
    {"drop-redundant", "occluders: none that lie on or in a larger solid"},
    {"occluders", "drawn per frame at most", kStandard.most_occluders, 0.0, 65536.0},
    {"polygons", "drawn per frame at most, pieces or triangles", kStandard.most_polygons, 0.0, 1e7},
    {"levels", "of the pyramid, above that of 8 x 8 cells", kStandard.levels, 0.0, kMostMapLevels},
    {"give-up", "share of a texel that is open, from which on it is not looked at closer",
     kStandard.give_up, 0.001, 1.0, false},
    {"depth-regions", "per axis", kStandard.depth_regions, 1.0, kMostDepthRegions},
    {"depth-of-cells", "no-background Z-buffer; off: boxes, the depth estimation buffer"},
    {"opacity", "of a texel of 8 x 8 cells that counts as covered where loss is accepted",
     kStandard.opacity, 0.0, 1.0, false},
    {"accept-px", "pixels that may be lost where approximate answers are demanded",
     kStandard.accepted_px, 0.0, 1e9, false},
};

class OcclusionMapMethod final : public Method {
 public:
  explicit OcclusionMapMethod(const OcclusionMapOptions& options) : options_(options) {}

  MethodInfo info() const noexcept override {
    return {"occlusion-map", "Zhang, Manocha, Hudson, Hoff 1997; Zhang 1998",
            options_.accepted_px > 0.0 ? Guarantee::kApproximate : Guarantee::kConservative,
            "triangles"};
  }
  std::span<const Setting> settings() const noexcept override { return kSettings; }
  std::unique_ptr<const Method> with(const SettingValues& values) const override {
    const auto count = [&](std::string_view name) {
      return static_cast<std::uint32_t>(values.number(name));
    };
    OcclusionMapOptions o;
    o.database = {values.number("least-size"), count("most-polygons"), values.number("least-fill"),
                  values.on("drop-redundant")};
    o.most_occluders = count("occluders");
    o.most_polygons = count("polygons");
    o.levels = count("levels");
    o.give_up = values.number("give-up");
    o.depth_regions = count("depth-regions");
    o.depth_of_cells = values.on("depth-of-cells");
    o.opacity = values.number("opacity");
    o.accepted_px = values.number("accept-px");
    return std::make_unique<OcclusionMapMethod>(o);
  }
  Result<void> accepts(const SceneProfile& /*profile*/) const override { return Done{}; }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    auto boxes = PreparedBoxes::of(std::move(scene));
    if (!boxes) return std::move(boxes).error();
    auto meshes = meshesOf(*boxes.value().scene());
    auto database = OccluderDatabase::of(*boxes.value().scene(), boxes.value().bvh(),
                                         meshes->occluders, options_.database);
    return std::unique_ptr<Culler>(std::make_unique<OcclusionMapCuller>(
        std::move(boxes).value(), std::move(meshes), std::move(database), options_, clock));
  }

 private:
  OcclusionMapOptions options_;
};

}  // namespace

const Method& occlusionMapMethod() noexcept {
  static const OcclusionMapMethod method{OcclusionMapOptions{}};
  return method;
}

}  // namespace culld
