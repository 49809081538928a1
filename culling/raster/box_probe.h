// A box as it is asked for: the cells that it may be on and how near it may be in each of them. Its
// front faces bound its nearness, the edges between them and its back faces its place
// (docs/error-model/z-pyramid.md §1).
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "culling/raster/box_kernels.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/depth_cells.h"
#include "culling/raster/nearest_plane.h"

namespace culld {

struct BoxProbe {
  /// Places of the image where a * u + b * v + c < 0 for sure are not on the box.
  struct Side {
    double a, b, c;
  };
  static constexpr std::size_t kMostSides = 6, kMostFaces = 3;

  CellRect rect{};       ///< nothing of the box is on other cells
  float nearest = 0.0F;  ///< nor nearer than this
  std::array<Side, kMostSides> sides;
  std::uint32_t side_count = 0;
  std::array<NearestPlane, kMostFaces> faces;
  std::uint32_t face_count = 0;

  /// Is the box surely on none of these cells?
  bool besides(const CellRect& cells) const noexcept;
  /// Nothing of the box is nearer over these cells.
  float nearestOver(const CellRect& cells) const noexcept;
};

/// Narrows `probe`, made of the box's rectangle and nearness, to what its faces show.
/// `origin_world` and `offsets`, `lane`: the box, as in projectBoxes but in the world.
/// COST: some 700 flops. Does nothing where the nearness is not finite.
void addFaces(const CellView& view, const glm::dvec3& camera_origin_world,
              const std::array<double, 3>& origin_world, BoxOffsets offsets, std::size_t lane,
              BoxProbe& probe);

}  // namespace culld
