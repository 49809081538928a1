// Every SIMD target against the scalar reference, bit for bit.
#include "culling/spatial/frustum_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "culling/core/simd.h"

namespace culld {
namespace {

class FrustumKernels : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { ASSERT_TRUE(forceSimdTarget(GetParam()).ok()); }
  void TearDown() override { ASSERT_TRUE(forceSimdTarget("auto").ok()); }
};

struct Case {
  alignas(32) float offsets[48];
  NodePlanes planes;
};

/// Any float at all now and then, else one of about the magnitude `scale`.
float anyFloat(std::mt19937_64& random, float scale) {
  constexpr float kInf = std::numeric_limits<float>::infinity();
  constexpr float kOdd[] = {0.0F,   -0.0F,   kInf,  -kInf,  std::numeric_limits<float>::quiet_NaN(),
                            1e-42F, -3e-45F, 3e38F, -3e38F, 1.2e-38F};
  if (random() % 40 == 0) return kOdd[random() % std::size(kOdd)];
  return scale * std::uniform_real_distribution<float>(-1.0F, 1.0F)(random);
}

Case randomCase(std::mt19937_64& random) {
  Case c;
  const float scale = std::pow(10.0F, static_cast<float>(random() % 61) - 30.0F);
  for (float& x : c.offsets) x = anyFloat(random, scale);
  c.planes.count = static_cast<std::uint32_t>(random() % (kMaxPlanes + 1));
  for (NodePlane& plane : c.planes.plane) {
    for (float& n : plane.normal) n = anyFloat(random, 1.0F);
    plane.base = anyFloat(random, scale);
    plane.slack = std::abs(anyFloat(random, scale * 1e-6F));
  }
  for (float& x : c.planes.eye_to_node) x = anyFloat(random, scale);
  if (random() % 2 == 0) {
    c.planes.turn = std::abs(anyFloat(random, 0.5F));
    c.planes.turn_slack = std::abs(anyFloat(random, scale * 1e-6F));
  }
  return c;
}

void expectEqual(const LaneBits& a, const LaneBits& b) {
  ASSERT_EQ(a.outside, b.outside);
  for (std::uint32_t p = 0; p < kMaxPlanes; ++p) ASSERT_EQ(a.inside[p], b.inside[p]) << p;
}

TEST_P(FrustumKernels, GiveTheReferencesBitsForAnyFloats) {
  std::mt19937_64 random(1);
  std::uint64_t outside = 0, inside = 0;
  for (int i = 0; i < 200000; ++i) {
    const Case c = randomCase(random);
    const LaneBits bits = testLanes(c.offsets, c.planes);
    ASSERT_NO_FATAL_FAILURE(expectEqual(bits, testLanesReference(c.offsets, c.planes))) << i;
    outside += bits.outside != 0 ? 1U : 0U;
    inside += bits.inside[0] != 0 ? 1U : 0U;
  }
  EXPECT_GT(outside, 20000U);  // both kinds of answers were compared
  EXPECT_GT(inside, 20000U);
}

TEST_P(FrustumKernels, GiveTheReferencesBitsWhereTheLastBitDecides) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 100000; ++i) {
    Case c = randomCase(random);
    for (float& x : c.offsets) x = std::uniform_real_distribution<float>(-1.0F, 1.0F)(random);
    c.planes.count = 1;
    c.planes.turn = 0.0F;
    NodePlane& plane = c.planes.plane[0];
    for (float& n : plane.normal) n = std::uniform_real_distribution<float>(-1.0F, 1.0F)(random);
    plane.base = std::uniform_real_distribution<float>(-1.0F, 1.0F)(random);
    // Lane k ends up within a few ulp of the margin's edge.
    float sum = plane.base, size = std::abs(plane.base);
    for (std::size_t a = 0; a < 3; ++a) {
      const float corner = c.offsets[(plane.normal[a] >= 0.0F ? a + 3 : a) * 8 + random() % 8];
      sum += plane.normal[a] * corner;
      size += std::abs(plane.normal[a] * corner);
    }
    plane.slack = 0.0F;
    plane.base -= sum + size * kFrustumMargin;
    ASSERT_NO_FATAL_FAILURE(
        expectEqual(testLanes(c.offsets, c.planes), testLanesReference(c.offsets, c.planes)));
  }
}

TEST_P(FrustumKernels, CallNoBoxWithNaNOutsideOrInside) {
  for (std::size_t broken = 0; broken < 6; ++broken) {
    Case c{};
    for (std::size_t row = 0; row < 6; ++row) {
      for (std::size_t lane = 0; lane < 8; ++lane) {
        c.offsets[row * 8 + lane] = row == broken ? std::nanf("") : (row < 3 ? -9.0F : -8.0F);
      }
    }
    c.planes.count = 2;
    c.planes.plane[0] = {{1.0F, 1.0F, 1.0F}, 0.0F, 0.0F};
    c.planes.plane[1] = {{-1.0F, -1.0F, -1.0F}, 0.0F, 0.0F};
    const LaneBits bits = testLanes(c.offsets, c.planes);
    // Each plane looks at three of the six rows; the rows it looks at decide.
    const std::uint32_t clean = broken < 3 ? 0xFFU : 0U;
    EXPECT_EQ(bits.outside, clean) << broken;
    EXPECT_EQ(bits.inside[1], broken < 3 ? 0xFFU : 0U) << broken;
  }
}

INSTANTIATE_TEST_SUITE_P(Targets, FrustumKernels, ::testing::ValuesIn(simdTargets()),
                         [](const auto& target) { return target.param; });

}  // namespace
}  // namespace culld
