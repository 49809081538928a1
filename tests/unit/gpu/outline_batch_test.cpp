// Attacks the thresholds of error-model/gpu.md §2: sides and planes that pass by a cell's corner
// within what floats can tell.
#include "culling/gpu/outline_batch.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>

namespace culld::gpu {
namespace {

constexpr int kRounds = 400'000;

/// As the shader has it.
float valueAt(const OutlineLine& line, std::uint32_t i, std::uint32_t j) {
  return line.a * static_cast<float>(i) + (line.c + line.b * static_cast<float>(j));
}

class OutlineBatchAttack : public testing::Test {
 protected:
  double real(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  std::uint32_t below(std::uint32_t most) { return static_cast<std::uint32_t>(random_() % most); }

  OutlineBatch batchOf(const SideLine* side, const DepthPlane* plane) {
    ConvexOutline outline;
    if (side != nullptr) outline.sides[outline.side_count++] = *side;
    if (plane != nullptr) outline.planes[outline.plane_count++] = *plane;
    OutlineBatch batch;
    batch.add(outline, grid_);
    return batch;
  }

  CellGrid grid_ = gridOf(1280, 720);
  std::mt19937_64 random_{11};
};

TEST_F(OutlineBatchAttack, ACellInsideASideHasAllOfItsCornersInside) {
  std::size_t inside = 0;
  for (int round = 0; round < kRounds; ++round) {
    SideLine side{real(-1.0, 1.0), 0.0, 0.0, round % 2 == 0 ? 0.0 : std::exp2(real(-30.0, -3.0))};
    side.b = (round % 4 < 2 ? 1.0 : -1.0) * (1.0 - std::abs(side.a));
    const std::uint32_t i = below(grid_.width), j = below(grid_.height);
    // The corner where the side's value is least.
    const double x = side.a < 0.0 ? i + 1.0 : i, y = side.b < 0.0 ? j + 1.0 : j;
    const double gap = std::exp2(real(-40.0, -6.0)) * (round % 3 == 0 ? -1.0 : 1.0);
    side.c = side.error + gap - side.a * x - side.b * y;
    const OutlineBatch batch = batchOf(&side, nullptr);
    if (!(valueAt(batch.lines[0], i, j) > batch.lines[0].least)) continue;
    ++inside;
    const long double least =
        static_cast<long double>(side.a) * x + static_cast<long double>(side.b) * y + side.c;
    ASSERT_GT(least, static_cast<long double>(side.error)) << "round " << round;
  }
  std::printf("%zu of %d cells inside\n", inside, kRounds);
  EXPECT_GT(inside, 1000U);
}

TEST_F(OutlineBatchAttack, NoCellIsNearerThanItsPlaneAnywhereInIt) {
  for (int round = 0; round < kRounds; ++round) {
    const double size = std::exp2(real(-60.0, 20.0));
    DepthPlane plane{size * real(-1.0, 1.0), size * real(-1.0, 1.0), 0.0, true};
    const std::uint32_t i = below(grid_.width), j = below(grid_.height);
    plane.c = -plane.a * i - plane.b * j + size * real(0.0, 2.0);
    const OutlineBatch batch = batchOf(nullptr, &plane);
    const double x = plane.a < 0.0 ? i + 1.0 : i, y = plane.b < 0.0 ? j + 1.0 : j;
    const long double least =
        static_cast<long double>(plane.a) * x + static_cast<long double>(plane.b) * y + plane.c;
    ASSERT_LE(static_cast<long double>(valueAt(batch.lines[0], i, j)), least) << "round " << round;
  }
}

float flushed(float x) { return std::fpclassify(x) == FP_SUBNORMAL ? 0.0F : x; }

/// As a shader has it that takes every denormal for 0.
float flushedValueAt(const OutlineLine& line, std::uint32_t i, std::uint32_t j) {
  const float a = flushed(line.a), b = flushed(line.b), c = flushed(line.c);
  const float across = flushed(a * static_cast<float>(i));
  const float rest = flushed(c + flushed(b * static_cast<float>(j)));
  return flushed(across + rest);
}

TEST_F(OutlineBatchAttack, AlsoWhereDenormalsCountAsZero) {
  const auto promised = [&](const DepthPlane& plane, std::uint32_t i, std::uint32_t j) {
    return flushedValueAt(batchOf(nullptr, &plane).lines[0], i, j);
  };
  EXPECT_LE(promised({-1.1e-38, 0.0, 1.2e-35, true}, 1200, 0), -1.1e-38 * 1201 + 1.2e-35);
  for (int round = 0; round < kRounds; ++round) {
    const double size = std::exp2(real(-140.0, -115.0));
    DepthPlane plane{size * real(-1.0, 1.0), size * real(-1.0, 1.0), 0.0, true};
    const std::uint32_t i = below(grid_.width), j = below(grid_.height);
    plane.c = -plane.a * i - plane.b * j + size * real(0.0, 2.0) + real(0.0, 1e-34);
    const double x = plane.a < 0.0 ? i + 1.0 : i, y = plane.b < 0.0 ? j + 1.0 : j;
    const long double least =
        static_cast<long double>(plane.a) * x + static_cast<long double>(plane.b) * y + plane.c;
    const float value = promised(plane, i, j);
    if (value < std::numeric_limits<float>::min()) continue;  // hides nothing
    ASSERT_LE(static_cast<long double>(value), least) << "round " << round;
  }
}

TEST_F(OutlineBatchAttack, AFaceTooSteepForFloatsLeavesTheFloor) {
  const SideLine side{1.0, 0.0, 0.0, 0.0};
  const DepthPlane steep{1e36, 0.0, 0.0, true};
  const OutlineBatch batch = batchOf(&side, &steep);
  EXPECT_EQ(batch.heads[0].planes, 0U);
  EXPECT_EQ(batch.lines.size(), 1U);
}

}  // namespace
}  // namespace culld::gpu
