#include "culling/raster/moving_view.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

namespace culld {
namespace {

// Outweighs the roundings of the lines that use it, some 1e-14 where they are conditioned worst.
constexpr double kUp = 1.0 + 1e-9;
constexpr double kMostWidening = 8.0;    ///< sides of the still grid; wider, nearly all is kept
constexpr double kMostCells = 2560.0;    ///< on the longer side; beyond, cells grow
constexpr double kMostMargin = 32.0;     ///< cells; what is carried farther is near and mostly seen
constexpr double kLeastRadius = 1e-100;  ///< metres; below, products of radii could underflow

/// The part of the image plane that a view must show, in cells of the still grid.
struct Extent {
  double x0, x1, y0, y1;
};

/// The directions through the corners of the image, of length 1, and where they are.
struct Corners {
  std::array<glm::dvec3, 4> direction;
  std::array<glm::dvec2, 4> cell;
};

Corners cornersOf(const CellView& view) {
  Corners corners;
  const glm::dvec3 u(view.u), v(view.v), w(view.w);
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec2 cell((i & 1) != 0 ? view.grid.width : 0, (i & 2) != 0 ? view.grid.height : 0);
    const glm::dvec3 along = glm::cross(u - cell.x * w, v - cell.y * w);
    const double length = glm::dot(w, along) < 0.0 ? -glm::length(along) : glm::length(along);
    corners.direction[i] = along / length;
    corners.cell[i] = cell;
  }
  return corners;
}

/// How far the image of a cap of directions about `corner`, `sine` wide, reaches to the right
/// (side = 1) or left (-1) of the corner's own place, where `row` is u or v less that place's w.
/// Infinite or NaN if the cap reaches the eye's plane.
double capReach(const glm::dvec3& row, const glm::dvec3& w, const glm::dvec3& corner, double sine,
                double side) {
  const double s = sine * sine, along = glm::dot(w, corner);
  const double a = along * along - s * glm::dot(w, w), b = s * glm::dot(row, w);
  if (!(a > 1e-4 * glm::dot(w, w)) || !(along > 0.0)) {
    return std::numeric_limits<double>::infinity();
  }
  return kUp * (side * -b + std::sqrt(b * b + a * s * glm::dot(row, row))) / a;
}

Extent turned(const CellView& view, const Corners& corners, double sine) {
  const glm::dvec3 u(view.u), v(view.v), w(view.w);
  // What rounding of rows could move a place by.
  const double pad = 0x1p-20 + 0x1p-44 * (glm::length(u) + glm::length(v)) / glm::length(w);
  Extent extent{-pad, view.grid.width + pad, -pad, view.grid.height + pad};
  for (std::size_t i = 0; i < 4; ++i) {
    const glm::dvec3& c = corners.direction[i];
    const glm::dvec2& at = corners.cell[i];
    const glm::dvec3 across = u - at.x * w, upward = v - at.y * w;
    extent.x0 = std::min(extent.x0, at.x - pad - capReach(across, w, c, sine, -1.0));
    extent.x1 = std::max(extent.x1, at.x + pad + capReach(across, w, c, sine, 1.0));
    extent.y0 = std::min(extent.y0, at.y - pad - capReach(upward, w, c, sine, -1.0));
    extent.y1 = std::max(extent.y1, at.y + pad + capReach(upward, w, c, sine, 1.0));
  }
  return extent;
}

/// Moves the image's origin and scales it to a grid of its own. False if it is much too wide.
bool show(CellView& view, const Extent& extent) {
  const double width = extent.x1 - extent.x0, height = extent.y1 - extent.y0;
  const double most = kMostWidening * std::max(view.grid.width, view.grid.height);
  if (!(width <= most) || !(height <= most)) return false;
  const double scale = std::min(1.0, kMostCells / std::max(width, height));
  view.grid = gridOf(static_cast<std::uint32_t>(std::max(std::ceil(width * scale), 1.0)),
                     static_cast<std::uint32_t>(std::max(std::ceil(height * scale), 1.0)));
  view.u = (view.u - extent.x0 * view.w) * (view.grid.width / width);
  view.v = (view.v - extent.y0 * view.w) * (view.grid.height / height);
  return true;
}

/// Blockers are to stay behind the plane for every eye of a camera that does not turn.
void moveCut(glm::dvec4& row, double radius) {
  row.w -= kUp * radius * glm::length(glm::dvec3(row));
}

/// The same for a camera that turns. A plane that does not cut the eye off cannot cut a blocker
/// alone: what lies behind it on the same ray is cut too. One that does is passed, along every
/// direction of the image, once w is large enough. False if some direction never passes it.
bool turnCut(glm::dvec4& row, const CellView& view, const Corners& corners, double radius) {
  if (row.w >= 0.0) {
    row = {0.0, 0.0, 0.0, 1.0};
    return true;
  }
  double least = std::numeric_limits<double>::infinity();
  for (const glm::dvec3& c : corners.direction)
    least = std::min(least, glm::dot(glm::dvec3(row), c));
  const double length = glm::length(glm::dvec3(row));
  if (!(least > 1e-4 * length)) return false;
  const double passed = kUp * (radius - row.w / least);
  row = view.w;
  row.w = -passed;
  return std::isfinite(passed);
}

EyeMotion eyeMotion(const CellView& view, double radius) {
  EyeMotion motion;
  motion.still = false;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<glm::dvec4::length_type>(axis);
    motion.u[axis] = radius * view.u[i];
    motion.v[axis] = radius * view.v[i];
    motion.w[axis] = radius * view.w[i];
  }
  motion.u_length = kUp * radius * glm::length(glm::dvec3(view.u));
  motion.v_length = kUp * radius * glm::length(glm::dvec3(view.v));
  motion.w_length = kUp * radius * glm::length(glm::dvec3(view.w));
  return motion;
}

/// What a moved eye sees lies elsewhere on this eye's image, by no more than the returned cells
/// times its nearness.
double mostCarried(const CellView& view, double radius) {
  const glm::dvec3 u(view.u), v(view.v), w(view.w);
  const double width = view.grid.width, height = view.grid.height;
  return kUp * radius *
         std::max({glm::length(u), glm::length(u - width * w), glm::length(v),
                   glm::length(v - height * w)});
}

/// Cells all around, for what moved eyes see there.
void addMargin(CellView& view, double radius) {
  const double carried = mostCarried(view, radius);
  const double margin = std::ceil(std::min(carried, kMostMargin));
  view.u += margin * view.w;
  view.v += margin * view.w;
  const auto cells = static_cast<std::uint32_t>(2.0 * margin);
  view.grid = gridOf(view.grid.width + cells, view.grid.height + cells);
  view.beside = margin / carried;
  view.behind_m = radius;
}

bool setPerspective(CellView& view, double radius, double angle) {
  if (angle > 0.0) {
    if (!(angle < 0.5 * std::numbers::pi)) return false;
    const Corners corners = cornersOf(view);
    if (!turnCut(view.near_cut, view, corners, radius)) return false;
    if (!turnCut(view.far_cut, view, corners, radius)) return false;
    if (!show(view, turned(view, corners, kUp * std::sin(angle)))) return false;
  } else {
    moveCut(view.near_cut, radius);
    moveCut(view.far_cut, radius);
  }
  if (radius > 0.0) {
    addMargin(view, radius);
    view.motion = eyeMotion(view, radius);
  }
  return true;
}

/// Rays are parallel: a moved eye sees the same image through a moved window, from another plane.
bool setOrthographic(CellView& view, double radius, double angle) {
  if (angle > 0.0) return false;
  moveCut(view.near_cut, radius);
  moveCut(view.far_cut, radius);
  const double right = kUp * radius * glm::length(glm::dvec3(view.u));
  const double up = kUp * radius * glm::length(glm::dvec3(view.v));
  return show(view, {-right, view.grid.width + right, -up, view.grid.height + up});
}

}  // namespace

CellView askedView(const CellView& view) noexcept {
  CellView asked = view;
  if (view.moves) {
    asked.motion = {};
    asked.front_sign = 0.0;
    asked.near_cut = asked.far_cut = {0.0, 0.0, 0.0, 1.0};
  }
  return asked;
}

bool setInMotion(CellView& view, const MotionBound& bound) noexcept {
  view.moves = true;
  const double radius = bound.radius_m > 0.0 ? std::max(kUp * bound.radius_m, kLeastRadius) : 0.0;
  return view.perspective ? setPerspective(view, radius, bound.angle_rad)
                          : setOrthographic(view, radius, bound.angle_rad);
}

}  // namespace culld
