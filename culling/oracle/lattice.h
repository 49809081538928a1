// Where the samples of an image lie: an even lattice over it, thinner than asked if that would be
// too many rays.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "culling/core/camera.h"

namespace culld::oracle {

inline constexpr std::size_t kRowsPerPart = 4;  ///< of one thread at a time

inline std::size_t partsOf(std::size_t count, std::size_t size) {
  return (count + size - 1) / size;
}

/// Normalized device coordinate of a place within a cell; `within` from 0 to 1.
inline double ndcWithin(std::size_t cell, double within, std::size_t cells) {
  return (static_cast<double>(cell) + within) / static_cast<double>(cells) * 2.0 - 1.0;
}

class Lattice {
 public:
  /// About side * side samples in each pixel, and no more than `most` in all.
  Lattice(const Camera& camera, std::uint32_t side, std::uint64_t most) {
    const double across = std::max(1.0, static_cast<double>(side)) * camera.width_px;
    const double down = std::max(1.0, static_cast<double>(side)) * camera.height_px;
    const double allowed = static_cast<double>(std::max<std::uint64_t>(1, most));
    const double thin = std::min(1.0, std::sqrt(allowed / (across * down)));
    columns_ = static_cast<std::size_t>(std::max(1.0, std::floor(across * thin)));
    rows_ = static_cast<std::size_t>(std::max(1.0, std::floor(down * thin)));
    pixels_per_sample_ = static_cast<double>(camera.width_px) * camera.height_px /
                         static_cast<double>(columns_ * rows_);
  }
  std::size_t columns() const noexcept { return columns_; }
  std::size_t rows() const noexcept { return rows_; }
  double pixelsPerSample() const noexcept { return pixels_per_sample_; }

 private:
  std::size_t columns_ = 1, rows_ = 1;
  double pixels_per_sample_ = 1.0;
};

}  // namespace culld::oracle
