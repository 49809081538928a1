#include "culling/raster/box_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "tests/unit/raster/every_target.h"

namespace culld {
namespace {

struct Boxes {
  float offsets[6][kBoxLanes];
};

Camera cameraFor(std::mt19937_64& random, bool perspective) {
  std::uniform_real_distribution<double> real(-1.0, 1.0);
  if (perspective) {
    LookAt look;
    look.target = {real(random), real(random), real(random)};
    look.eye = {3.0 * real(random), 3.0 * real(random), 5.0};
    return cameraFromLookAt(look, {}).value();
  }
  glm::dmat4 projection(1.0);
  projection[0][0] = 0.1 + std::abs(real(random));
  projection[2][2] = -0.01;
  return cameraFromMatrices(glm::dmat4(1.0), projection, {}).value();
}

TEST(BoxKernels, EqualTheReferenceOnEveryTargetForAnyNumbers) {
  onEveryTarget([] {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<float> real(-1.0F, 1.0F);
    const float odd[] = {0.0F,
                         std::numeric_limits<float>::infinity(),
                         3.0e38F,
                         -3.0e38F,
                         1e-40F,
                         std::numeric_limits<float>::quiet_NaN(),
                         -std::numeric_limits<float>::infinity()};
    for (int round = 0; round < 4000; ++round) {
      Camera camera = cameraFor(random, round % 3 != 0);
      if (round % 2 != 0) camera.motion.radius_m = 0.3;
      const BoxView view = boxView(cellView(camera, gridFor(camera)));
      const float scale = std::exp2(static_cast<float>(static_cast<int>(random() % 40) - 10));
      Boxes boxes;
      for (std::size_t lane = 0; lane < kBoxLanes; ++lane) {
        for (std::size_t i = 0; i < 3; ++i) {
          const float a = scale * real(random), b = scale * real(random);
          boxes.offsets[i][lane] = std::min(a, b);
          boxes.offsets[i + 3][lane] = std::max(a, b);
        }
        if (random() % 8 == 0) boxes.offsets[random() % 6][lane] = odd[random() % std::size(odd)];
      }
      const std::array<double, 3> origin{4.0 * scale * real(random), real(random), -scale};
      BoxRects got, expected;
      projectBoxes(view, origin, boxes.offsets, got);
      projectBoxesReference(view, origin, boxes.offsets, expected);
      ASSERT_EQ(got.off_grid, expected.off_grid);
      for (std::size_t lane = 0; lane < kBoxLanes; ++lane) {
        ASSERT_EQ(got.x0[lane], expected.x0[lane]);
        ASSERT_EQ(got.x1[lane], expected.x1[lane]);
        ASSERT_EQ(got.y0[lane], expected.y0[lane]);
        ASSERT_EQ(got.y1[lane], expected.y1[lane]);
        ASSERT_EQ(got.nearest[lane], expected.nearest[lane]);
      }
    }
  });
}

TEST(BoxKernels, ABoxWithNaNGetsTheWholeGrid) {
  const Camera camera = cameraFromLookAt({}, {}).value();
  const BoxView view = boxView(cellView(camera, gridFor(camera)));
  Boxes boxes{};
  boxes.offsets[0][3] = std::numeric_limits<float>::quiet_NaN();
  BoxRects rects;
  projectBoxes(view, {0.0, 0.0, -5.0}, boxes.offsets, rects);
  EXPECT_EQ(rects.off_grid, 0U);
  EXPECT_EQ(rects.x0[3], 0.0F);
  EXPECT_EQ(rects.x1[3], view.width);
  EXPECT_TRUE(std::isinf(rects.nearest[3]));
}

}  // namespace
}  // namespace culld
