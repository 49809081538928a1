#include "culling/raster/outline_kernels.h"

#include <random>

#include "tests/unit/raster/every_target.h"

namespace culld {
namespace {

class RandomSquares {
 public:
  OutlineSquare square() {
    OutlineSquare s;
    s.sides = static_cast<std::uint32_t>(random_() % 7);
    for (std::uint32_t k = 0; k < s.sides; ++k) {
      s.a[k] = real(-8.0F, 8.0F);
      s.b[k] = real(-8.0F, 8.0F);
      s.c[k] = real(-10.0F, 80.0F);
      s.full[k] = real(0.0F, 8.0F);
      s.some[k] = s.full[k] - real(0.0F, 60.0F);
    }
    s.planes = 1 + static_cast<std::uint32_t>(random_() % 3);
    for (std::uint32_t p = 0; p < s.planes; ++p) {
      s.plane_a[p] = real(-0.1F, 0.1F);
      s.plane_b[p] = real(-0.1F, 0.1F);
      s.plane_c[p] = real(-0.2F, 1.0F);
      s.plane_rise[p] = real(0.0F, 0.2F);
    }
    s.depth_floor = real(-0.2F, 0.5F);
    s.depth_ceiling = real(0.5F, 1.0F);
    return s;
  }
  std::uint64_t bits() { return random_(); }
  float real(float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(random_);
  }

 private:
  std::mt19937_64 random_{7};
};

TEST(OutlineKernels, EqualTheReferenceOnEveryTarget) {
  onEveryTarget([] {
    RandomSquares random;
    std::size_t partly = 0;
    for (int round = 0; round < 5000; ++round) {
      const OutlineSquare square = random.square();
      std::array<float, 64> nearness;
      for (float& n : nearness) n = random.real(0.0F, 1.0F);
      OutlineMasks masks, expected;
      outlineMasks(square, nearness.data(), masks);
      outlineMasksReference(square, nearness.data(), expected);
      ASSERT_EQ(masks.full, expected.full);
      ASSERT_EQ(masks.some, expected.some);
      for (std::uint32_t s = 0; s < square.sides; ++s) {
        ASSERT_EQ(masks.full_of_side[s], expected.full_of_side[s]);
      }
      ASSERT_EQ(masks.raisable, expected.raisable);
      ASSERT_EQ(outlineInside(square), expected.full);
      ASSERT_EQ(outlineInsideReference(square), expected.full);
      if (expected.full != 0 && ~expected.full != 0) ++partly;
      std::array<float, 64> raised = nearness;
      const std::uint64_t covered = random.bits();
      ASSERT_EQ(raiseOutline(square, covered, nearness.data()),
                raiseOutlineReference(square, covered, raised.data()));
      ASSERT_EQ(nearness, raised);
    }
    EXPECT_GT(partly, 1000U);
  });
}

TEST(OutlineKernels, RaiseOnlyWhatIsCoveredAndNeverLower) {
  OutlineSquare square;
  square.planes = 1;
  square.plane_a[0] = 0.125F;
  square.plane_b[0] = 0.0F;
  square.plane_c[0] = 0.0F;
  square.depth_floor = 0.25F;
  std::array<float, 64> nearness;
  nearness.fill(0.5F);
  EXPECT_EQ(raiseOutline(square, 0b11100111, nearness.data()), 0.5F);
  const std::array<float, 8> row{0.5F, 0.5F, 0.5F, 0.5F, 0.5F, 0.625F, 0.75F, 0.875F};
  for (std::size_t i = 0; i < 8; ++i) EXPECT_EQ(nearness[i], row[i]);
  for (std::size_t i = 8; i < 64; ++i) EXPECT_EQ(nearness[i], 0.5F);
}

}  // namespace
}  // namespace culld
