// Without a backend, which is how this program runs: the scene is refused with the reason, and
// whoever asks all the same gets the frustum's answer. With one: tests/unit/gpu, tests/soundness.
#include "culling/methods/gpu_depth_pyramid.h"

#include <gtest/gtest.h>

#include "culling/methods/frustum.h"
#include "tests/scenes/random_scene.h"

namespace culld {
namespace {

TEST(GpuDepthPyramid, RefusesEverySceneAndSaysWhyThereIsNoGpu) {
  const auto refused = gpuDepthPyramidMethod().accepts({});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(refused.error().message, "gpu-depth-pyramid: no backend was asked for");
}

TEST(GpuDepthPyramid, AnswersWhatTheFrustumHoldsWithoutAGpu) {
  const SnapshotPtr scene = scenes::randomScene(3);
  const auto culler = gpuDepthPyramidMethod().prepare(scene).value();
  const auto frustum = frustumMethod().prepare(scene).value();
  for (const auto& spec : scenes::randomCameras(3, *scene, 3)) {
    const Camera camera = scenes::toCamera(spec).value();
    ViewState view, other;
    const Answer answer = culler->cull(camera, {}, view);
    EXPECT_EQ(answer.visible, frustum->cull(camera, {}, other).visible);
    EXPECT_EQ(answer.note, "gpu-depth-pyramid: no backend was asked for");
  }
}

}  // namespace
}  // namespace culld
