// The parts of `gpu-depth-pyramid`, each shown to bring something by counts.
#include <gtest/gtest.h>

#include <new>
#include <vector>

#include "culling/culler.h"
#include "culling/gpu/depth_pass.h"
#include "culling/scene/scene_builder.h"
#include "tests/scenes/city.h"
#include "tests/scenes/random_scene.h"
#include "tests/scenes/shapes.h"
#include "tests/unit/gpu/opened_backend.h"

namespace culld {
namespace {

struct Sums {
  std::size_t answered = 0, drawn = 0, in_frustum = 0;
};

class GpuDepthPyramid : public gpu::WithBackend {
 protected:
  const Culler& culler(const std::string& settings, const SnapshotPtr& scene) {
    auto method = configured_.find("gpu-depth-pyramid" + settings);
    EXPECT_TRUE(method.ok());
    kept_.push_back(method.value()->prepare(scene).value());
    return *kept_.back();
  }

  /// With small images: a software renderer draws.
  Sums fly(const std::string& settings, const SnapshotPtr& scene,
           const std::vector<scenes::CameraSpec>& cameras) {
    const Culler& flown = culler(settings, scene);
    ViewState view;
    Sums sums;
    for (scenes::CameraSpec spec : cameras) {
      spec.image = {320, 180};
      const Answer answer = flown.cull(scenes::toCamera(spec).value(), {}, view);
      EXPECT_EQ(answer.note, "");
      sums.answered += answer.visible.size();
      sums.drawn += answer.stats.occluders_drawn;
      sums.in_frustum += answer.stats.in_frustum;
    }
    return sums;
  }

  static const scenes::City& city() {
    static const scenes::City made = [] {
      scenes::CityOptions options;
      options.objects = 2000;
      options.frames = 8;
      return scenes::generateCity(options);
    }();
    return made;
  }

  ConfiguredMethods configured_{allMethods()};
  std::vector<std::unique_ptr<Culler>> kept_;
};

TEST_F(GpuDepthPyramid, CoherenceDrawsLess) {
  const SnapshotPtr scene = scenes::toSnapshot(city().model);
  const Sums with = fly("", scene, city().cameras);
  const Sums without = fly(":coherence=off", scene, city().cameras);
  std::printf("drawn %zu, without %zu; answered %zu of %zu in the frustum\n", with.drawn,
              without.drawn, with.answered, with.in_frustum);
  EXPECT_EQ(with.answered, without.answered);
  EXPECT_LT(with.drawn, without.drawn);
  EXPECT_LT(with.answered, with.in_frustum / 2);
}

TEST_F(GpuDepthPyramid, FinerLevelsHideMore) {
  const SnapshotPtr scene = scenes::toSnapshot(city().model);
  const std::vector<scenes::CameraSpec> some(city().cameras.begin(), city().cameras.begin() + 3);
  std::size_t answered = fly(":refine=0", scene, some).answered;
  for (const char* refine : {":refine=1", ":refine=2", ":refine=3"}) {
    const std::size_t finer = fly(refine, scene, some).answered;
    EXPECT_LT(finer, answered) << refine;
    answered = finer;
  }
}

TEST_F(GpuDepthPyramid, FlatFacesHideToo) {
  std::size_t with = 0, without = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    const SnapshotPtr scene = scenes::randomScene(seed);
    const auto cameras = scenes::randomCameras(seed, *scene, 2);
    with += fly("", scene, cameras).answered;
    without += fly(":faces=0", scene, cameras).answered;
  }
  EXPECT_LT(with, without);
}

TEST_F(GpuDepthPyramid, UploadsNothingAgainWhileTheSceneStays) {
  const SnapshotPtr scene = scenes::toSnapshot(city().model);
  const Culler& flown = culler("", scene);
  const auto uploads = [] {
    auto lease = gpu::backend()->acquire();
    const std::uint64_t made = lease.value().data<gpu::DepthPass>().uploads();
    EXPECT_TRUE(lease.value().check().ok());
    return made;
  };
  ViewState view;
  const Camera camera = scenes::toCamera(city().cameras[0]).value();
  flown.cull(camera, {}, view);
  const std::uint64_t before = uploads();
  for (int i = 0; i < 3; ++i) flown.cull(camera, {}, view);
  EXPECT_EQ(uploads(), before);
}

TEST_F(GpuDepthPyramid, AFrameThatBrokeOffLeavesNothingToTheNext) {
  const SnapshotPtr scene = scenes::toSnapshot(city().model);
  const Culler& flown = culler("", scene);
  const Camera first = scenes::toCamera(city().cameras.front()).value();
  const Camera next = scenes::toCamera(city().cameras.back()).value();
  ViewState view, fresh;
  gpu::Faults::exception = true;
  EXPECT_THROW(flown.cull(first, {}, view), std::bad_alloc);
  EXPECT_EQ(flown.cull(next, {}, view).visible, flown.cull(next, {}, fresh).visible);
}

SnapshotPtr alone(const scenes::Triangles& shape, double size) {
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(makeMesh({{shape.positions, shape.indices, true, false}}));
  builder.addInstance(mesh, {size, 0, 0, 0, 0, size, 0, 0, 0, 0, size, 0}, 0);
  return builder.finish();
}

TEST_F(GpuDepthPyramid, DrawsAMeshOfManyPiecesInParts) {
  constexpr int kAcross = 160, kPieces = kAcross * kAcross;
  scenes::Triangles wall;
  for (int i = 0; i < kPieces; ++i) {
    const glm::vec3 low(i % kAcross, i / kAcross, 0);
    const auto first = static_cast<std::uint32_t>(wall.positions.size());
    const scenes::Triangles box = scenes::box(low, low + glm::vec3(0.9F));
    wall.positions.insert(wall.positions.end(), box.positions.begin(), box.positions.end());
    for (const std::uint32_t index : box.indices) wall.indices.push_back(first + index);
  }
  const SnapshotPtr scene = alone(wall, 1.0);
  LookAt look;
  look.target = {0.5 * kAcross, 0.5 * kAcross, 0.0};
  look.eye = look.target + glm::dvec3(0.0, 0.0, 1.2 * kAcross);
  const Camera camera = cameraFromLookAt(look, {}).value();
  ViewState view;
  gpu::Seen::most_outlines_drawn = 0;
  EXPECT_EQ(culler("", scene).cull(camera, {}, view).note, "");
  EXPECT_EQ(gpu::Seen::most_outlines_drawn, static_cast<int>(gpu::OutlineBatch::kMostHeads));
}

TEST_F(GpuDepthPyramid, AsksNothingWhereNoBoxIsLeftToAsk) {
  const SnapshotPtr wall = alone(scenes::box(glm::vec3(-1, -1, -2), glm::vec3(1, 1, -1)), 1e19);
  LookAt look;
  look.zfar_m = 1e20;
  const Camera camera = cameraFromLookAt(look, {}).value();
  ViewState view;
  gpu::Seen::dispatches = 0;
  const Answer answer = culler("", wall).cull(camera, {}, view);
  EXPECT_EQ(answer.note, "");
  EXPECT_EQ(answer.visible, std::vector<ObjectId>{0});
  EXPECT_EQ(answer.stats.occluders_drawn, 1U);
  EXPECT_EQ(gpu::Seen::dispatches, 0);
}

}  // namespace
}  // namespace culld
