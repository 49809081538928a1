// One triangle against one block of 8 x 8 cells: which cells it fills, touches, or has a rim in,
// and how far its farthest point over each cell is. docs/error-model.md §4 proves the thresholds.
// coverage_kernels.cpp is the Highway code, coverage_reference.cpp the scalar truth; equal bytes.
#pragma once
#include <array>
#include <cstdint>

#include "culling/raster/triangle_setup.h"

namespace culld {

/// Where in a cell its sample point lies: off the diagonals and middles where inner edges like to
/// be.
inline constexpr double kSampleX = 0.4371, kSampleY = 0.5613;

/// A triangle's half-planes a * i + b * j + c over the cells (i, j) of one block, i and j in [0,
/// 8), each with three thresholds on its value at the cell's lower corner.
struct BlockTriangle {
  std::array<float, kMaxSides> a{}, b{}, c{};
  std::array<float, kMaxSides> inside{};  ///< value >= inside: the whole closed cell is inside
  std::array<float, kMaxSides> touch{};   ///< value < touch: the closed cell is outside
  std::array<float, kMaxSides> sample{};  ///< value >= sample: the cell's sample point is inside
  std::uint32_t sides = 3;
  std::uint32_t net_sides = 0;  ///< bit s: side s is an edge of the sheet, not an inner edge
  /// Nearness of the plane's farthest point over cell (i, j): depth_a * i + depth_b * j + depth_c,
  /// never less than depth_floor.
  float depth_a = 0.0F, depth_b = 0.0F, depth_c = 0.0F, depth_floor = 0.0F;
};

/// What a sheet has done to one block so far. Bit 8 * j + i stands for cell (i, j).
struct SheetBlock {
  std::uint64_t rim = 0;             ///< a net edge may touch the cell
  std::uint64_t sampled = 0;         ///< a triangle surely holds the cell's sample point
  std::array<float, 64> farthest{};  ///< least nearness of any triangle that may touch the cell
  void clear() noexcept {
    rim = 0;
    sampled = 0;
    farthest.fill(3.0e38F);
  }
};

/// Adds the triangle to the sheet, and to `nearness` (64 cells) where it alone fills a cell.
void addTriangle(const BlockTriangle& triangle, SheetBlock& sheet, float* nearness);
void addTriangleReference(const BlockTriangle& triangle, SheetBlock& sheet, float* nearness);

/// The cells that one of the net sides may touch, as far as the triangle does.
std::uint64_t rimCells(const BlockTriangle& triangle);
std::uint64_t rimCellsReference(const BlockTriangle& triangle);

/// Raises the cells of `covered` to the sheet's farthest nearness; returns the block's least
/// nearness.
float raiseCells(std::uint64_t covered, const float* farthest, float* nearness);
float raiseCellsReference(std::uint64_t covered, const float* farthest, float* nearness);

/// The cells whose nearness is > `limit`.
std::uint64_t cellsNearerThan(const float* nearness, float limit);
std::uint64_t cellsNearerThanReference(const float* nearness, float limit);

}  // namespace culld
