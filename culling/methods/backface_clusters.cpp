#include "culling/methods/backface_clusters.h"

#include <memory>
#include <utility>

#include "culling/box_answer.h"
#include "culling/core/parallel.h"
#include "culling/methods/backface_clusters_frame.h"
#include "culling/spatial/prepared_boxes.h"

namespace culld {
namespace {

/// By mesh. Meshes never change, so edits share it.
using SharedClusters = std::shared_ptr<const std::vector<FacingClusters>>;

SharedClusters clustersOf(const SceneSnapshot& scene, const ClusterRules& rules) {
  std::vector<FacingClusters> clusters(scene.meshCount());
  parallelFor(clusters.size(), [&](std::size_t i) {
    clusters[i] = FacingClusters::of(scene.mesh(static_cast<MeshId>(i)), rules);
  });
  return std::make_shared<const std::vector<FacingClusters>>(std::move(clusters));
}

class BackfaceClustersCuller final : public Culler {
 public:
  BackfaceClustersCuller(PreparedBoxes boxes, SharedClusters clusters,
                         const BackfaceClustersOptions& options, const Clock& clock)
      : boxes_(std::move(boxes)),
        clusters_(std::move(clusters)),
        options_(options),
        clock_(clock) {}

  Answer cull(const Camera& camera, const Demand& demand, ViewState& view) const override {
    const auto run = [&](const Deadline& deadline, Answer& answer) -> std::string_view {
      if (!holdsInMotion(camera)) return "no one image holds for the motion bound";
      const BackfaceClustersScene scene{*boxes_.scene(), boxes_.bvh(), *clusters_};
      BackfaceClustersFrame(scene, options_, camera, deadline, demand,
                            view.memory<BackfaceClustersMemory>())
          .run(answer);
      return {};
    };
    return answerBy("backface-clusters", boxes_, clock_, camera, demand, run);
  }

  Result<std::unique_ptr<Culler>> edited(SnapshotPtr next,
                                         std::span<const ObjectId> changed) const override {
    auto boxes = boxes_.edited(std::move(next), changed);
    if (!boxes) return std::move(boxes).error();
    return std::unique_ptr<Culler>(std::make_unique<BackfaceClustersCuller>(
        std::move(boxes).value(), clusters_, options_, clock_));
  }

  std::size_t preparedBytes() const noexcept override {
    std::size_t bytes = boxes_.bytes();
    for (const FacingClusters& clusters : *clusters_) bytes += clusters.bytes();
    return bytes;
  }

 private:
  PreparedBoxes boxes_;
  SharedClusters clusters_;
  BackfaceClustersOptions options_;
  const Clock& clock_;
};

constexpr BackfaceClustersOptions kStandard{};

constexpr Setting kSettings[] = {
    {"objects", "leaves out objects of which all triangles turn away"},
    {"occluders", "draws the nearest objects, and leaves out what they hide"},
    {"clusters", "draws occluders without the clusters that turn away"},
    {"hierarchy", "asks clusters from the top; off: those of the leaves alone, all of them"},
    {"by-position", "near triangles go into one cluster"},
    {"by-normal", "triangles with like normals go into one cluster"},
    {"leaf", "triangles up to which a cluster is not divided", kStandard.rules.leaf, 1, 1024},
    {"triangles", "of occluders looked at one by one per frame at most", kStandard.most_triangles,
     0.0, 1e7},
};

class BackfaceClustersMethod final : public Method {
 public:
  explicit BackfaceClustersMethod(const BackfaceClustersOptions& options) : options_(options) {}

  MethodInfo info() const noexcept override {
    return {"backface-clusters", "Kumar, Manocha, Garrett, Lin 1999 (HBFC)",
            Guarantee::kConservative, "triangles"};
  }
  std::span<const Setting> settings() const noexcept override { return kSettings; }
  std::unique_ptr<const Method> with(const SettingValues& values) const override {
    BackfaceClustersOptions o;
    o.objects = values.on("objects");
    o.occluders = values.on("occluders");
    o.clusters = values.on("clusters");
    o.hierarchy = values.on("hierarchy");
    o.rules = {static_cast<std::uint32_t>(values.number("leaf")), values.on("by-position"),
               values.on("by-normal")};
    o.most_triangles = static_cast<std::uint32_t>(values.number("triangles"));
    return std::make_unique<BackfaceClustersMethod>(o);
  }
  Result<void> accepts(const SceneProfile& /*profile*/) const override { return Done{}; }
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override {
    auto boxes = PreparedBoxes::of(std::move(scene));
    if (!boxes) return std::move(boxes).error();
    SharedClusters clusters = clustersOf(*boxes.value().scene(), options_.rules);
    return std::unique_ptr<Culler>(std::make_unique<BackfaceClustersCuller>(
        std::move(boxes).value(), std::move(clusters), options_, clock));
  }

 private:
  BackfaceClustersOptions options_;
};

}  // namespace

const Method& backfaceClustersMethod() noexcept {
  static const BackfaceClustersMethod method{BackfaceClustersOptions{}};
  return method;
}

}  // namespace culld
