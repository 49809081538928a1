// How often a test repeats itself on random input.
#pragma once
#include <cstdint>

namespace culld::scenes {

/// `full`, or an eighth of it under a sanitizer: there the code is ten times slower, and what is
/// looked for does not hide in the thousandth scene.
constexpr std::uint64_t rounds(std::uint64_t full) {
#ifdef CULLD_SANITIZED
  return (full + 7) / 8;
#else
  return full;
#endif
}

}  // namespace culld::scenes
