// Space cut by planes across the three axes into voxels, and one bit for each of them. The planes
// need not be evenly spaced: where they lie on the walls of a scene, even a thin wall fills voxels.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <span>
#include <vector>

#include "culling/core/box.h"

namespace culld {

using Voxel = std::array<std::uint32_t, 3>;

/// Half-open, by axis.
struct VoxelRange {
  Voxel first{0, 0, 0}, last{0, 0, 0};
  bool empty() const noexcept {
    return first[0] >= last[0] || first[1] >= last[1] || first[2] >= last[2];
  }
  std::uint64_t size() const noexcept {
    if (empty()) return 0;
    return std::uint64_t{last[0] - first[0]} * (last[1] - first[1]) * (last[2] - first[2]);
  }
  bool holds(const Voxel& v) const noexcept;
  bool operator==(const VoxelRange&) const = default;
};

class VoxelGrid {
 public:
  /// REQUIRES: at least two planes per axis, finite and strictly ascending.
  explicit VoxelGrid(std::array<std::vector<double>, 3> planes) : planes_(std::move(planes)) {}

  Voxel counts() const noexcept;
  VoxelRange all() const noexcept { return {{0, 0, 0}, counts()}; }
  std::span<const double> planes(std::size_t axis) const noexcept { return planes_[axis]; }
  Box boundsOf(const VoxelRange& range) const noexcept;

  /// All voxels that share a point with the box, be it on their rim. NaN shares with all.
  VoxelRange touching(const Box& box) const noexcept;
  /// All voxels that lie within the box, rim included. NaN holds none.
  VoxelRange within(const Box& box) const noexcept;

  std::size_t bytes() const noexcept;

 private:
  template <typename PlanesOf>
  VoxelRange axisByAxis(const Box& box, const PlanesOf& planes_of) const noexcept;

  std::array<std::vector<double>, 3> planes_;
};

/// One bit per voxel, rows along x in whole words; bits past the end of a row are 0.
class VoxelBits {
 public:
  using Word = std::uint64_t;
  static constexpr std::uint32_t kWordBits = 64;

  explicit VoxelBits(const Voxel& counts);

  const Voxel& counts() const noexcept { return counts_; }
  std::uint32_t wordsPerRow() const noexcept { return words_per_row_; }
  std::span<Word> row(std::uint32_t y, std::uint32_t z) noexcept {
    return {words_.data() + rowStart(y, z), words_per_row_};
  }
  std::span<const Word> row(std::uint32_t y, std::uint32_t z) const noexcept {
    return {words_.data() + rowStart(y, z), words_per_row_};
  }
  bool test(const Voxel& v) const noexcept {
    return (words_[rowStart(v[1], v[2]) + v[0] / kWordBits] >> v[0] % kWordBits & 1U) != 0;
  }
  void set(const Voxel& v) noexcept {
    words_[rowStart(v[1], v[2]) + v[0] / kWordBits] |= Word{1} << v[0] % kWordBits;
  }
  void fill(const VoxelRange& range) noexcept;
  void clear(const VoxelRange& range) noexcept;
  /// Adds the bits of `part`, whose first voxel is `at` of these. REQUIRES: it fits in, and
  /// at[0] is a multiple of kWordBits.
  void unite(const VoxelBits& part, const Voxel& at) noexcept;
  /// REQUIRES: equal counts.
  void subtract(const VoxelBits& other) noexcept;
  bool any(const VoxelRange& range) const noexcept;
  bool every(const VoxelRange& range) const noexcept;
  std::uint64_t count() const noexcept;
  std::size_t bytes() const noexcept { return words_.size() * sizeof(Word); }
  bool operator==(const VoxelBits&) const = default;

  /// The bits [first, last) of word `word` of a row.
  static Word mask(std::uint32_t word, std::uint32_t first, std::uint32_t last) noexcept;

 private:
  std::size_t rowStart(std::uint32_t y, std::uint32_t z) const noexcept {
    return (std::size_t{z} * counts_[1] + y) * words_per_row_;
  }

  Voxel counts_;
  std::uint32_t words_per_row_;
  std::vector<Word> words_;
};

}  // namespace culld
