#include "culling/spatial/voxel_grid.h"

#include <algorithm>
#include <bit>

namespace culld {
namespace {

struct Planes {
  std::ptrdiff_t first, last;
};

/// Calls take(word, mask) for the words of a range until it returns false. Returns false then.
template <typename Bits, typename Take>
bool forEachWord(Bits& bits, const VoxelRange& range, const Take& take) {
  if (range.empty()) return true;
  const std::uint32_t first = range.first[0] / VoxelBits::kWordBits;
  const std::uint32_t last = (range.last[0] - 1) / VoxelBits::kWordBits;
  const auto first_mask = VoxelBits::mask(first, range.first[0], range.last[0]);
  const auto last_mask = VoxelBits::mask(last, range.first[0], range.last[0]);
  for (std::uint32_t z = range.first[2]; z < range.last[2]; ++z) {
    for (std::uint32_t y = range.first[1]; y < range.last[1]; ++y) {
      const auto row = bits.row(y, z);
      if (!take(row[first], first_mask)) return false;
      if (first == last) continue;
      for (std::uint32_t w = first + 1; w < last; ++w) {
        if (!take(row[w], ~VoxelBits::Word{0})) return false;
      }
      if (!take(row[last], last_mask)) return false;
    }
  }
  return true;
}

}  // namespace

bool VoxelRange::holds(const Voxel& v) const noexcept {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (v[axis] < first[axis] || v[axis] >= last[axis]) return false;
  }
  return true;
}

Voxel VoxelGrid::counts() const noexcept {
  Voxel counts{};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    counts[axis] = static_cast<std::uint32_t>(planes_[axis].size() - 1);
  }
  return counts;
}

Box VoxelGrid::boundsOf(const VoxelRange& range) const noexcept {
  if (range.empty()) return {};
  Box box;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    box.min[axis] = planes_[a][range.first[a]];
    box.max[axis] = planes_[a][range.last[a]];
  }
  return box;
}

/// The voxels between the planes that `planes_of` names for each axis; none if it names none.
template <typename PlanesOf>
VoxelRange VoxelGrid::axisByAxis(const Box& box, const PlanesOf& planes_of) const noexcept {
  VoxelRange range;
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const Planes planes = planes_of(planes_[a], box.min[axis], box.max[axis]);
    if (planes.last <= planes.first) return {};
    range.first[a] = static_cast<std::uint32_t>(planes.first);
    range.last[a] = static_cast<std::uint32_t>(planes.last);
  }
  return range;
}

VoxelRange VoxelGrid::touching(const Box& box) const noexcept {
  return axisByAxis(box, [](const std::vector<double>& p, double low, double high) {
    // The voxel before the first plane that is not below `low` ends on or beyond it.
    const auto below = std::partition_point(p.begin(), p.end(), [&](double x) { return x < low; });
    const auto above =
        std::partition_point(p.begin(), p.end(), [&](double x) { return !(x > high); });
    if (below == p.end() || above == p.begin()) return Planes{0, 0};
    const auto first = below - p.begin(), last = above - p.begin();
    return Planes{first == 0 ? 0 : first - 1, std::min(last, std::ssize(p) - 1)};
  });
}

VoxelRange VoxelGrid::within(const Box& box) const noexcept {
  return axisByAxis(box, [](const std::vector<double>& p, double low, double high) {
    const auto first =
        std::partition_point(p.begin(), p.end(), [&](double x) { return !(x >= low); });
    const auto end = std::partition_point(p.begin(), p.end(), [&](double x) { return x <= high; });
    return Planes{first - p.begin(), end - p.begin() - 1};
  });
}

std::size_t VoxelGrid::bytes() const noexcept {
  return (planes_[0].size() + planes_[1].size() + planes_[2].size()) * sizeof(double);
}

VoxelBits::VoxelBits(const Voxel& counts)
    : counts_(counts),
      words_per_row_((counts[0] + kWordBits - 1) / kWordBits),
      words_(std::size_t{words_per_row_} * counts[1] * counts[2], 0) {}

VoxelBits::Word VoxelBits::mask(std::uint32_t word, std::uint32_t first,
                                std::uint32_t last) noexcept {
  const std::uint32_t start = word * kWordBits;
  const std::uint32_t from = std::clamp(first, start, start + kWordBits) - start;
  const std::uint32_t to = std::clamp(last, start, start + kWordBits) - start;
  if (from >= to) return 0;
  return (~Word{0} >> (kWordBits - (to - from))) << from;
}

void VoxelBits::fill(const VoxelRange& range) noexcept {
  forEachWord(*this, range, [](Word& word, Word mask) {
    word |= mask;
    return true;
  });
}

void VoxelBits::clear(const VoxelRange& range) noexcept {
  forEachWord(*this, range, [](Word& word, Word mask) {
    word &= ~mask;
    return true;
  });
}

void VoxelBits::unite(const VoxelBits& part, const Voxel& at) noexcept {
  for (std::uint32_t z = 0; z < part.counts_[2]; ++z) {
    for (std::uint32_t y = 0; y < part.counts_[1]; ++y) {
      const auto from = part.row(y, z);
      const auto to = row(y + at[1], z + at[2]).subspan(at[0] / kWordBits);
      for (std::size_t w = 0; w < from.size(); ++w) to[w] |= from[w];
    }
  }
}

void VoxelBits::subtract(const VoxelBits& other) noexcept {
  for (std::size_t w = 0; w < words_.size(); ++w) words_[w] &= ~other.words_[w];
}

bool VoxelBits::any(const VoxelRange& range) const noexcept {
  return !forEachWord(*this, range, [](Word word, Word mask) { return (word & mask) == 0; });
}

bool VoxelBits::every(const VoxelRange& range) const noexcept {
  return forEachWord(*this, range, [](Word word, Word mask) { return (word & mask) == mask; });
}

std::uint64_t VoxelBits::count() const noexcept {
  std::uint64_t sum = 0;
  for (const Word word : words_) sum += static_cast<std::uint64_t>(std::popcount(word));
  return sum;
}

}  // namespace culld
