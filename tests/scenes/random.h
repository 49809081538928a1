// The same random numbers on every standard library, so that a seed names a scene. Arguments of a
// call are evaluated in any order: two draws go into braces or into statements of their own.
#pragma once
#include <cstdint>
#include <random>

namespace culld::scenes {

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// In [0, 1).
  double unit() { return static_cast<double>(engine_() >> 11) * 0x1p-53; }
  double uniform(double low, double high) { return low + (high - low) * unit(); }
  /// In [0, count). REQUIRES: count > 0.
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(unit() * count); }
  bool chance(double probability) { return unit() < probability; }
  std::uint64_t seed() { return engine_(); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace culld::scenes
