// Convex outlines (culling/raster/convex_outline.h) as a shader wants them: lines and planes over
// the whole grid, rounded to floats on the safe side. docs/error-model/gpu.md §2 proves how.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "culling/raster/cell_view.h"
#include "culling/raster/convex_outline.h"

namespace culld::gpu {

/// a * i + (c + b * j) at the lower corner of cell (i, j). Of a side: all of the cell is inside
/// where that is > least. Of a plane: what is covered is at least so near; `least` is not used.
struct OutlineLine {
  float a, b, c, least;
};

/// The cells [x0, x1) x [y0, y1) are asked: sides hold nowhere else. Sides come first, then planes.
struct OutlineHead {
  std::uint32_t x0, y0, x1, y1;
  std::uint32_t first_line, sides, planes;
  float floor;
};
static_assert(sizeof(OutlineLine) == 16 && sizeof(OutlineHead) == 32);  // std430

struct OutlineBatch {
  std::vector<OutlineHead> heads;
  std::vector<OutlineLine> lines;

  void clear() noexcept {
    heads.clear();
    lines.clear();
  }
  void add(const ConvexOutline& outline, const CellGrid& grid);

  /// To be drawn before more is added: arrays stay below the 16 MiB that a shader sees of an array
  /// on every OpenGL 4.5.
  bool full() const noexcept { return heads.size() >= kMostHeads; }
  static constexpr std::size_t kMostHeads = 16384;
};

static_assert(OutlineBatch::kMostHeads * (kMostOutlineSides + kMostOutlinePlanes) *
                  sizeof(OutlineLine) <=
              std::size_t{1} << 24U);

}  // namespace culld::gpu
