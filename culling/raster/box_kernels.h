// Eight boxes at a time to outer-conservative rectangles of cells and their nearest nearness.
// docs/error-model.md §5 proves the margins. box_reference.cpp is the scalar truth; equal bytes.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "culling/raster/cell_view.h"

namespace culld {

inline constexpr std::size_t kBoxLanes = 8;

/// CellView in float. Rows u, v, w, n as (x, y, z, constant).
struct BoxView {
  std::array<float, 4> u{}, v{}, w{}, n{};
  bool perspective = true;
  float width = 0.0F, height = 0.0F;  ///< grid, cells
  /// For an eye that moves: what is nearer than this may be on its image from elsewhere though it
  /// is beside the grid, and what is behind it by less than `behind` metres, too.
  float beside = std::numeric_limits<float>::infinity();
  float behind = 0.0F;
};

BoxView boxView(const CellView& view) noexcept;

/// Offsets of eight boxes from a common origin: min x, y, z, max x, y, z, each eight lanes.
using BoxOffsets = const float (*)[kBoxLanes];

/// Per lane, in cells: contains every point of the box that may be on the image.
struct BoxRects {
  alignas(32) std::array<float, kBoxLanes> x0, x1, y0, y1;
  alignas(32) std::array<float, kBoxLanes> nearest;  ///< no point of the box is nearer
  /// bit l: box l is surely beside the image or behind the eye, wherever that is
  std::uint32_t off_grid = 0;
};

/// `origin` is the common origin relative to the camera's, metres, not yet rounded to float.
/// A box that may reach the eye's plane gets the whole grid and infinite nearness. One of which a
/// part beside the grid may be on the image from elsewhere gets infinite nearness too.
void projectBoxes(const BoxView& view, const std::array<double, 3>& origin, BoxOffsets offsets,
                  BoxRects& out);
void projectBoxesReference(const BoxView& view, const std::array<double, 3>& origin,
                           BoxOffsets offsets, BoxRects& out);

}  // namespace culld
