#include "culling/raster/cell_view.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

#include "culling/raster/moving_view.h"

namespace culld {
namespace {

constexpr double kMinLongSide = 256.0, kMaxLongSide = 1280.0;

std::uint32_t cellsFor(std::uint32_t pixels, double scale) {
  const double cells = std::ceil(static_cast<double>(pixels) * scale);
  return static_cast<std::uint32_t>(std::clamp(cells, 1.0, kMaxLongSide));
}

/// Sign of det(u, v, toward the eye), 0 where rounding could decide it.
double frontSign(const glm::dvec3& u, const glm::dvec3& v, const glm::dvec3& toward) {
  const glm::dvec3 normal = glm::cross(u, v);
  const double det = glm::dot(normal, toward);
  const double scale = glm::length(u) * glm::length(v) * glm::length(toward);
  const double error = 16.0 * std::numeric_limits<double>::epsilon() * scale;
  if (!(std::abs(det) > error)) return 0.0;
  return det > 0.0 ? 1.0 : -1.0;
}

CellView stillView(const Camera& camera, const CellGrid& grid) noexcept {
  CellView view;
  view.grid = grid;
  view.u = (camera.x_row + camera.w_row) * (0.5 * grid.width);
  view.v = (camera.y_row + camera.w_row) * (0.5 * grid.height);
  view.w = camera.w_row;
  view.n = camera.near_row;
  view.near_cut = camera.near_cut_row;
  view.far_cut = camera.far_cut_row;
  view.perspective = camera.perspective;
  if (camera.perspective) {  // w in metres along the axis, whatever the projection's scale
    const double scale = 1.0 / glm::length(glm::dvec3(camera.w_row));
    for (glm::dvec4* row : {&view.u, &view.v, &view.w, &view.near_cut, &view.far_cut})
      *row *= scale;
  }
  const glm::dvec3 toward =
      camera.perspective ? -glm::dvec3(camera.w_row) : glm::dvec3(camera.near_row);
  view.front_sign = frontSign(glm::dvec3(camera.x_row), glm::dvec3(camera.y_row), toward);
  return view;
}

}  // namespace

CellGrid gridOf(std::uint32_t width, std::uint32_t height) noexcept {
  CellGrid grid;
  grid.width = width;
  grid.height = height;
  grid.blocks_x = (grid.width + kBlockSide - 1) / kBlockSide;
  grid.blocks_y = (grid.height + kBlockSide - 1) / kBlockSide;
  grid.tiles_x = (grid.blocks_x + kTileSide - 1) / kTileSide;
  grid.tiles_y = (grid.blocks_y + kTileSide - 1) / kTileSide;
  return grid;
}

CellGrid gridFor(const Camera& camera) noexcept {
  const double longer = std::max(camera.width_px, camera.height_px);
  const double scale = std::clamp(longer, kMinLongSide, kMaxLongSide) / longer;
  return gridOf(cellsFor(camera.width_px, scale), cellsFor(camera.height_px, scale));
}

CellView cellView(const Camera& camera, const CellGrid& grid) noexcept {
  CellView view = stillView(camera, grid);
  if (!camera.motion.still()) setInMotion(view, camera.motion);
  return view;
}

bool holdsInMotion(const Camera& camera) noexcept {
  if (camera.motion.still()) return true;
  CellView view = stillView(camera, gridFor(camera));
  return setInMotion(view, camera.motion);
}

}  // namespace culld
