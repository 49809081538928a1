#include "culling/raster/occludee_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/unit/raster/every_target.h"

namespace culld {
namespace {

class RandomOccludees {
 public:
  double real(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  float single(double low, double high) { return static_cast<float>(real(low, high)); }
  bool chance(unsigned one_in) { return random_() % one_in == 0; }

  ObjectRow row(double size) {
    return {real(-size, size), real(-size, size), real(-size, size), real(-size, size)};
  }
  OccludeeView view() {
    OccludeeView v;
    v.rows = {row(600), row(400), row(1), row(0.1), row(1), row(1), {}};
    v.rows.w.constant += real(0.0, 3.0);
    v.rows.error = {1e-10, 1e-10, chance(3) ? 0.3 : 1e-13, 1e-13, 1e-13, 1e-13, {}};
    v.width = 640;
    v.height = 360;
    v.perspective = chance(2);
    v.may_be_cut = chance(2);
    return v;
  }
  TriangleLanes triangles() {
    TriangleLanes t{};
    const double huge = chance(10) ? 1e38 : 1.0;
    for (auto& coordinate : t.coordinate) {
      for (float& x : coordinate) x = single(-huge, huge);
    }
    if (chance(10)) t.coordinate[random_() % 9][random_() % 8] = std::nanf("");
    if (chance(10)) t.coordinate[random_() % 9][random_() % 8] = HUGE_VALF;
    return t;
  }
  BlockTriangle block() {
    BlockTriangle t;
    t.sides = static_cast<std::uint32_t>(random_() % (kMaxSides + 1));
    for (std::uint32_t s = 0; s < t.sides; ++s) {
      t.a[s] = single(-1, 1);
      t.b[s] = single(-1, 1);
      t.c[s] = single(-8, 8);
      t.touch[s] = single(-1, 0);
    }
    return t;
  }

 private:
  std::mt19937_64 random_{11};
};

TEST(OccludeeKernels, ProjectTrianglesEqualsTheReferenceOnEveryTarget) {
  onEveryTarget([] {
    RandomOccludees random;
    std::uint32_t seen = 0, unseen = 0;
    for (int round = 0; round < 3000; ++round) {
      const OccludeeView view = random.view();
      const TriangleLanes triangles = random.triangles();
      for (const double front : {-1.0, 0.0, 1.0}) {
        TriangleRects rects, expected;
        projectTriangles(view, triangles, front, rects);
        projectTrianglesReference(view, triangles, front, expected);
        ASSERT_EQ(rects.unseen, expected.unseen) << round;
        ASSERT_EQ(rects.x0, expected.x0) << round;
        ASSERT_EQ(rects.x1, expected.x1) << round;
        ASSERT_EQ(rects.y0, expected.y0) << round;
        ASSERT_EQ(rects.y1, expected.y1) << round;
        ASSERT_EQ(rects.nearest, expected.nearest) << round;
        (rects.unseen == 0 ? seen : unseen) += 1;
      }
    }
    EXPECT_GT(seen, 100U);
    EXPECT_GT(unseen, 100U);
  });
}

TEST(OccludeeKernels, CellsNotHidingEqualsTheReferenceOnEveryTarget) {
  onEveryTarget([] {
    RandomOccludees random;
    std::uint32_t open = 0, none = 0;
    for (int round = 0; round < 3000; ++round) {
      std::array<float, 64> nearness{};
      for (float& f : nearness) f = random.single(0, 1);
      const BlockTriangle triangle = random.block();
      const BlockNearest nearest{random.single(-0.1, 0.1), random.single(-0.1, 0.1),
                                 random.single(-1, 1),
                                 random.chance(3) ? HUGE_VALF : random.single(0, 1)};
      const float least = random.single(-0.5, 0.5);
      const std::uint64_t cells = cellsNotHiding(triangle, nearest, least, nearness.data());
      ASSERT_EQ(cells, cellsNotHidingReference(triangle, nearest, least, nearness.data()));
      (cells == 0 ? none : open) += 1;
    }
    EXPECT_GT(open, 100U);
    EXPECT_GT(none, 100U);
  });
}

TEST(OccludeeKernels, ACellHidesNothingThatIsAsNearOrNearerThanItAndNothingWhereNothingIsProven) {
  BlockTriangle everywhere;
  everywhere.sides = 0;
  std::array<float, 64> nearness;
  nearness.fill(0.25F);
  nearness[9] = std::nextafter(0.25F, 1.0F);
  EXPECT_EQ(cellsNotHiding(everywhere, {0.0F, 0.0F, 0.25F, 1.0F}, 0.0F, nearness.data()),
            ~(std::uint64_t{1} << 9));
  EXPECT_EQ(cellsNotHiding(everywhere, {0.0F, 0.0F, 1.0F, 0.25F}, 0.0F, nearness.data()),
            ~(std::uint64_t{1} << 9));
  nearness.fill(0.0F);
  EXPECT_EQ(cellsNotHiding(everywhere, {0.0F, 0.0F, -1.0F, 1.0F}, 0.0F, nearness.data()),
            ~std::uint64_t{0});
  EXPECT_EQ(cellsNotHiding(everywhere, {0.0F, 0.0F, 0.25F, 1.0F}, 0.26F, nearness.data()), 0U);
}

}  // namespace
}  // namespace culld
