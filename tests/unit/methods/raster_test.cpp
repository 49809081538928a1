#include "culling/methods/raster.h"

#include <gtest/gtest.h>

#include "culling/methods/frustum.h"
#include "tests/unit/spatial/box_scene.h"

namespace culld::testing {
namespace {

Camera lookingFrom(double x) {
  LookAt look;
  look.eye = {x, 10.0, 120.0};
  look.target = {0.5 * x, 0.0, 0.0};
  return cameraFromLookAt(look, {}).value();
}

TEST(Raster, CountsAsManyObjectsInTheFrustumAsTheFrustumFinds) {
  for (const std::size_t count : {100U, 5000U}) {
    const SnapshotPtr scene = boxScene(randomBoxes(count, {0, 0, 0}, 60.0, 3));
    const auto raster = rasterMethod().prepare(scene);
    const auto frustum = frustumMethod().prepare(scene);
    ASSERT_TRUE(raster.ok() && frustum.ok());
    std::size_t hidden = 0;
    for (int n = 0; n < 20; ++n) {
      ViewState view;
      const Answer with = raster.value()->cull(lookingFrom(6.0 * n - 60.0), {}, view);
      const Answer without = frustum.value()->cull(lookingFrom(6.0 * n - 60.0), {}, view);
      EXPECT_EQ(with.stats.in_frustum, without.stats.in_frustum);
      EXPECT_LE(with.visible.size(), without.visible.size());
      hidden += without.visible.size() - with.visible.size();
    }
    EXPECT_GT(hidden, 0U);
  }
}

TEST(Raster, SharesTheBoxesOfAnotherMethodsCuller) {
  const SnapshotPtr scene = boxScene(randomBoxes(5000, {0, 0, 0}, 60.0, 3));
  const auto frustum = frustumMethod().prepare(scene);
  ASSERT_TRUE(frustum.ok());
  const auto beside = rasterMethod().prepareBeside(*frustum.value(), scene, steadyClock());
  const auto alone = rasterMethod().prepare(scene);
  ASSERT_TRUE(beside.ok() && alone.ok());
  ViewState one, other;
  EXPECT_EQ(beside.value()->cull(lookingFrom(0), {}, one).visible,
            alone.value()->cull(lookingFrom(0), {}, other).visible);
}

TEST(Raster, PricesItsWork) {
  const SnapshotPtr scene = boxScene(randomBoxes(5000, {0, 0, 0}, 60.0, 3));
  const auto raster = rasterMethod().prepare(scene);
  const auto frustum = frustumMethod().prepare(scene);
  ViewState one, other;
  const auto with = raster.value()->cull(lookingFrom(0), {}, one).stats;
  const auto without = frustum.value()->cull(lookingFrom(0), {}, other).stats;
  EXPECT_GT(without.work.count(), 0);
  EXPECT_GT(with.work, without.work);
}

}  // namespace
}  // namespace culld::testing
