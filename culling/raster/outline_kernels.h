// A convex outline on a square of 8 x 8 parts: the blocks of a tile, or the cells of a block. Which
// parts lie inside all sides, and how near what is inside them surely is. docs/error-model.md §4.6
// proves the thresholds. outline_reference.cpp is the scalar truth; equal bytes.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

namespace culld {

inline constexpr std::size_t kMostOutlineSides = 24;
inline constexpr std::size_t kMostOutlinePlanes = 8;

/// Bit 8 * j + i of a mask, and place 8 * j + i of an array, stand for part (i, j).
struct OutlineSquare {
  /// Side s has the value a * i + b * j + c at the lower corner of part (i, j).
  std::array<float, kMostOutlineSides> a, b, c;
  std::array<float, kMostOutlineSides> full;  ///< value >= full: the whole part is inside
  std::array<float, kMostOutlineSides> some;  ///< value < some: no cell of the part is inside
  std::uint32_t sides = 0;
  /// Nearness of plane p over all of part (i, j) is at least plane_a * i + plane_b * j + plane_c.
  std::array<float, kMostOutlinePlanes> plane_a, plane_b, plane_c;
  std::array<float, kMostOutlinePlanes> plane_rise;  ///< and at most so much more
  std::uint32_t planes = 0;
  float depth_floor = 0.0F;    ///< nor is what is covered ever less near than this
  float depth_ceiling = 0.0F;  ///< nor nearer than this

  void addConstant(float low, float high) noexcept {
    plane_a[planes] = plane_b[planes] = 0.0F;
    plane_c[planes] = low;
    plane_rise[planes] = high - low;
    ++planes;
  }
};

struct OutlineMasks {
  std::uint64_t full = 0;      ///< inside all sides
  std::uint64_t some = 0;      ///< maybe inside all sides in some cell
  std::uint64_t raisable = 0;  ///< may be nearer than it is proven so far
  std::array<std::uint64_t, kMostOutlineSides> full_of_side;
};

/// `nearness`: of the 64 parts, so far.
void outlineMasks(const OutlineSquare& square, const float* nearness, OutlineMasks& masks);
void outlineMasksReference(const OutlineSquare& square, const float* nearness, OutlineMasks& masks);

/// OutlineMasks::full alone.
std::uint64_t outlineInside(const OutlineSquare& square);
std::uint64_t outlineInsideReference(const OutlineSquare& square);

/// Raises the 64 parts in `covered` to what is proven of them. Returns the least of all 64.
float raiseOutline(const OutlineSquare& square, std::uint64_t covered, float* nearness);
float raiseOutlineReference(const OutlineSquare& square, std::uint64_t covered, float* nearness);

}  // namespace culld
