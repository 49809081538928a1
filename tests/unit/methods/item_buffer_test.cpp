// Without a backend, which is how this program runs: the scene is refused with the reason, and
// whoever asks all the same gets the frustum's answer. With one: tests/unit/gpu, tests/soundness.
#include "culling/methods/item_buffer.h"

#include <gtest/gtest.h>

#include "culling/methods/frustum.h"
#include "tests/scenes/random_scene.h"

namespace culld {
namespace {

TEST(ItemBuffer, RefusesEverySceneAndSaysWhyThereIsNoGpu) {
  const auto refused = itemBufferMethod().accepts({});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(refused.error().message, "item-buffer: no backend was asked for");
}

TEST(ItemBuffer, AnswersWhatTheFrustumHoldsWithoutAGpu) {
  const SnapshotPtr scene = scenes::randomScene(3);
  const auto culler = itemBufferMethod().prepare(scene).value();
  const auto frustum = frustumMethod().prepare(scene).value();
  for (const auto& spec : scenes::randomCameras(3, *scene, 3)) {
    const Camera camera = scenes::toCamera(spec).value();
    ViewState view, other;
    const Answer answer = culler->cull(camera, {.guarantee = Guarantee::kSampled}, view);
    EXPECT_EQ(answer.visible, frustum->cull(camera, {}, other).visible);
    EXPECT_EQ(answer.guarantee, Guarantee::kConservative);
    EXPECT_EQ(answer.note, "item-buffer: no backend was asked for");
  }
}

}  // namespace
}  // namespace culld
