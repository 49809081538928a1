#include "culling/raster/coverage_kernels.h"

#include <gtest/gtest.h>

#include <random>

#include "tests/unit/raster/every_target.h"

namespace culld {
namespace {

class RandomBlocks {
 public:
  BlockTriangle triangle() {
    BlockTriangle t;
    t.sides = static_cast<std::uint32_t>(random_() % (kMaxSides + 1));
    for (std::uint32_t s = 0; s < t.sides; ++s) {
      t.a[s] = real(-1.0F, 1.0F);
      t.b[s] = real(-1.0F, 1.0F);
      t.c[s] = real(-8.0F, 8.0F);
      t.inside[s] = real(0.0F, 1.0F);
      t.touch[s] = -t.inside[s];
      t.sample[s] = real(-0.5F, 0.5F);
    }
    t.net_sides = static_cast<std::uint32_t>(random_()) & ((1U << t.sides) - 1);
    t.depth_a = real(-0.1F, 0.1F);
    t.depth_b = real(-0.1F, 0.1F);
    t.depth_c = real(0.1F, 2.0F);
    t.depth_floor = real(0.0F, 1.0F);
    return t;
  }
  float real(float low, float high) {
    return std::uniform_real_distribution<float>(low, high)(random_);
  }
  std::uint64_t bits() { return random_(); }

 private:
  std::mt19937_64 random_{7};
};

TEST(CoverageKernels, AddTriangleEqualsTheReferenceOnEveryTarget) {
  onEveryTarget([] {
    RandomBlocks blocks;
    for (int round = 0; round < 3000; ++round) {
      SheetBlock sheet, expected_sheet;
      sheet.clear();
      expected_sheet.clear();
      std::array<float, 64> nearness{}, expected{};
      for (int k = 0; k < 4; ++k) {
        const BlockTriangle t = blocks.triangle();
        addTriangle(t, sheet, nearness.data());
        addTriangleReference(t, expected_sheet, expected.data());
        ASSERT_EQ(rimCells(t), rimCellsReference(t));
      }
      ASSERT_EQ(sheet.rim, expected_sheet.rim);
      ASSERT_EQ(sheet.sampled, expected_sheet.sampled);
      ASSERT_EQ(sheet.farthest, expected_sheet.farthest);
      ASSERT_EQ(nearness, expected);
    }
  });
}

TEST(CoverageKernels, RaiseAndCompareEqualTheReferenceOnEveryTarget) {
  onEveryTarget([] {
    RandomBlocks blocks;
    for (int round = 0; round < 3000; ++round) {
      std::array<float, 64> nearness{}, farthest{};
      for (float& f : nearness) f = blocks.real(0.0F, 1.0F);
      for (float& f : farthest) f = blocks.real(0.0F, 1.0F);
      std::array<float, 64> expected = nearness;
      const std::uint64_t covered = blocks.bits();
      ASSERT_EQ(raiseCells(covered, farthest.data(), nearness.data()),
                raiseCellsReference(covered, farthest.data(), expected.data()));
      ASSERT_EQ(nearness, expected);
      const float limit = nearness[static_cast<std::size_t>(round) % 64];
      ASSERT_EQ(cellsNearerThan(nearness.data(), limit),
                cellsNearerThanReference(nearness.data(), limit));
    }
  });
}

TEST(CoverageKernels, ACellAtTheSameNearnessIsNotNearer) {
  std::array<float, 64> nearness;
  nearness.fill(0.25F);
  nearness[9] = std::nextafter(0.25F, 1.0F);
  EXPECT_EQ(cellsNearerThan(nearness.data(), 0.25F), std::uint64_t{1} << 9);
}

}  // namespace
}  // namespace culld
