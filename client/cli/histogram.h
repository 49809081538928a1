// Latencies by the million in a few kilobytes: buckets that grow with the value, each 1.6 % wide.
#pragma once
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

namespace culld::client {

class Histogram {
 public:
  void record(std::uint64_t value) noexcept {
    ++counts_[bucketOf(value)];
    ++count_;
    if (value > max_) max_ = value;
  }
  void add(const Histogram& other) noexcept {
    for (std::size_t i = 0; i < counts_.size(); ++i) counts_[i] += other.counts_[i];
    count_ += other.count_;
    if (other.max_ > max_) max_ = other.max_;
  }
  std::uint64_t count() const noexcept { return count_; }
  std::uint64_t max() const noexcept { return max_; }

  /// The smallest bucket that so large a share of the values does not exceed, by its upper end;
  /// 0 of none.
  std::uint64_t quantile(double share) const noexcept {
    const double wanted = share * static_cast<double>(count_);
    std::uint64_t passed = 0;
    for (std::size_t i = 0; i < counts_.size(); ++i) {
      passed += counts_[i];
      if (passed > 0 && static_cast<double>(passed) >= wanted) {
        return upperEnd(i) < max_ ? upperEnd(i) : max_;
      }
    }
    return max_;
  }

 private:
  static constexpr unsigned kBits = 6;  // of a value that tell its bucket, below the highest

  static std::size_t bucketOf(std::uint64_t value) noexcept {
    const auto width = static_cast<unsigned>(std::bit_width(value));
    if (width <= kBits + 1) return static_cast<std::size_t>(value);
    const unsigned shift = width - (kBits + 1);
    return (std::size_t{shift} << kBits) + static_cast<std::size_t>(value >> shift);
  }
  static std::uint64_t upperEnd(std::size_t bucket) noexcept {
    if (bucket < (std::size_t{2} << kBits)) return bucket;
    const std::size_t shift = (bucket >> kBits) - 1;
    const std::uint64_t lead = bucket - (shift << kBits);
    return ((lead + 1) << shift) - 1;
  }

  std::array<std::uint64_t, std::size_t{59} << kBits> counts_{};
  std::uint64_t count_ = 0, max_ = 0;
};

}  // namespace culld::client
