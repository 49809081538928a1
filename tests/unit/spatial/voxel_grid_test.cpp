#include "culling/spatial/voxel_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace culld {
namespace {

VoxelGrid uneven() {
  return VoxelGrid({std::vector{0.0, 1.0, 1.5, 4.0}, {-1.0, 0.0, 2.0}, {10.0, 11.0}});
}

TEST(VoxelGrid, TouchingIsWhateverSharesAPointAndWithinIsWhatFitsIn) {
  const VoxelGrid grid = uneven();
  EXPECT_EQ(grid.counts(), (Voxel{3, 2, 1}));
  // On a plane: the voxels on both sides of it are touched.
  EXPECT_EQ(grid.touching({{1.0, -0.5, 10.5}, {1.0, -0.5, 10.5}}),
            (VoxelRange{{0, 0, 0}, {2, 1, 1}}));
  EXPECT_EQ(grid.touching({{1.1, 0.0, 9.0}, {1.4, 5.0, 10.0}}), (VoxelRange{{1, 0, 0}, {2, 2, 1}}));
  EXPECT_TRUE(grid.touching({{4.1, 0.0, 10.0}, {5.0, 1.0, 11.0}}).empty());
  EXPECT_TRUE(grid.touching({{-2.0, 0.0, 10.0}, {-0.1, 1.0, 11.0}}).empty());
  EXPECT_EQ(grid.within({{0.5, -1.0, 10.0}, {4.0, 2.0, 11.0}}), (VoxelRange{{1, 0, 0}, {3, 2, 1}}));
  EXPECT_TRUE(grid.within({{0.5, -1.0, 10.0}, {1.4, 2.0, 11.0}}).empty());
}

TEST(VoxelGrid, NanTouchesAllAndHoldsNone) {
  const VoxelGrid grid = uneven();
  const glm::dvec3 nan(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(grid.touching({nan, nan}), grid.all());
  EXPECT_TRUE(grid.within({nan, nan}).empty());
}

TEST(VoxelGrid, EveryPointOfABoxLiesInAVoxelThatItTouches) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> place(-2.0, 12.0);
  const VoxelGrid grid = uneven();
  for (int i = 0; i < 20'000; ++i) {
    Box box;
    box.grow(glm::dvec3(place(random), place(random), place(random)));
    box.grow(glm::dvec3(place(random), place(random), place(random)));
    const VoxelRange range = grid.touching(box);
    for (std::uint32_t x = 0; x < 3; ++x) {
      for (std::uint32_t y = 0; y < 2; ++y) {
        const Box voxel = grid.boundsOf({{x, y, 0}, {x + 1, y + 1, 1}});
        bool meets = true;
        for (int a = 0; a < 3; ++a) {
          meets = meets && voxel.min[a] <= box.max[a] && box.min[a] <= voxel.max[a];
        }
        EXPECT_EQ(range.holds({x, y, 0}), meets);
      }
    }
  }
}

/// Bit by bit what VoxelBits does by words.
TEST(VoxelBits, RangesAreWhatTheirBitsAre) {
  std::mt19937 engine(5);
  const auto random = [&] { return static_cast<std::uint32_t>(engine()); };
  const Voxel counts{150, 3, 4};
  VoxelBits bits(counts);
  std::vector<bool> truth(150 * 3 * 4, false);
  const auto at = [](std::uint32_t x, std::uint32_t y, std::uint32_t z) {
    return (std::size_t{z} * 3 + y) * 150 + x;
  };
  for (int i = 0; i < 400; ++i) {
    VoxelRange range;
    for (std::size_t a = 0; a < 3; ++a) {
      range.first[a] = random() % counts[a];
      range.last[a] = range.first[a] + random() % (counts[a] - range.first[a] + 1);
    }
    const int what = static_cast<int>(random() % 3);
    if (what == 0) bits.fill(range);
    if (what == 1) bits.clear(range);
    bool any = false, every = true;
    for (std::uint32_t z = range.first[2]; z < range.last[2]; ++z) {
      for (std::uint32_t y = range.first[1]; y < range.last[1]; ++y) {
        for (std::uint32_t x = range.first[0]; x < range.last[0]; ++x) {
          if (what == 0) truth[at(x, y, z)] = true;
          if (what == 1) truth[at(x, y, z)] = false;
          any = any || truth[at(x, y, z)];
          every = every && truth[at(x, y, z)];
        }
      }
    }
    EXPECT_EQ(bits.any(range), any);
    EXPECT_EQ(bits.every(range), every || range.empty());
    EXPECT_EQ(bits.count(),
              static_cast<std::uint64_t>(std::count(truth.begin(), truth.end(), true)));
  }
}

TEST(VoxelBits, AreUnitedAtAPlaceAndSubtracted) {
  VoxelBits all({200, 4, 4}), part({70, 2, 2});
  part.set({0, 0, 0});
  part.set({69, 1, 1});
  all.unite(part, {64, 1, 2});
  EXPECT_TRUE(all.test({64, 1, 2}));
  EXPECT_TRUE(all.test({133, 2, 3}));
  EXPECT_EQ(all.count(), 2U);
  VoxelBits one({200, 4, 4});
  one.set({133, 2, 3});
  all.subtract(one);
  EXPECT_EQ(all.count(), 1U);
}

}  // namespace
}  // namespace culld
