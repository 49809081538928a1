#include "culling/methods/layers_order.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>

namespace culld {
namespace {

constexpr double kLeastClear = 1e-4;  ///< less is not worth going on for

using Waiting = LayersOrderMemory::Waiting;

bool lessClear(const Waiting& a, const Waiting& b) {
  if (a.clear != b.clear) return a.clear < b.clear;
  if (a.distance2 != b.distance2) return a.distance2 > b.distance2;
  return a.cell > b.cell;
}

double at(const glm::dvec4& row, const glm::dvec3& p) {
  return row.x * p.x + row.y * p.y + row.z * p.z + row.w;
}

}  // namespace

LayersOrder::LayersOrder(const SolidGrid& grid, const Camera& camera, double solidity,
                         LayersOrderMemory& memory)
    : grid_(grid),
      camera_(camera),
      solidity_(solidity),
      memory_(memory),
      eye_cell_(grid.cellAt(camera.origin_world)),
      image_px_(static_cast<double>(camera.width_px) * camera.height_px) {
  memory_.queue.clear();
  memory_.states.assign(grid.size(), {});
  const Box low = grid.reachOf({0, 0, 0});
  const auto& n = grid.counts();
  const Box high = grid.reachOf({n[0] - 1, n[1] - 1, n[2] - 1});
  for (int axis = 0; axis < 3; ++axis) {
    const double eye = camera.origin_world[axis];
    outside_[static_cast<std::size_t>(axis)] = !(eye >= low.min[axis] && eye <= high.max[axis]);
  }
  start();
}

/// The eye's own cell; or all cells of the sides of the grid that turn to it.
void LayersOrder::start() {
  const auto& n = grid_.counts();
  bool inside = true;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (!outside_[axis]) continue;
    inside = false;
    SolidGrid::Cell cell;
    cell[axis] = eye_cell_[axis];
    const std::size_t b = (axis + 1) % 3, c = (axis + 2) % 3;
    for (cell[b] = 0; cell[b] < n[b]; ++cell[b]) {
      for (cell[c] = 0; cell[c] < n[c]; ++cell[c]) reach(cell, weight(cell, axis));
    }
  }
  if (inside) reach(eye_cell_, 1.0);
}

/// How much of the sight to the cell comes in along the axis: as the sight's direction leans to it.
double LayersOrder::weight(const SolidGrid::Cell& cell, std::size_t axis) const {
  const Box box = grid_.boundsOf(cell);
  const glm::dvec3 towards = 0.5 * (box.min + box.max) - camera_.origin_world;
  double sum = 0.0;
  for (std::size_t a = 0; a < 3; ++a) {
    if (cell[a] != eye_cell_[a] || outside_[a]) sum += std::abs(towards[static_cast<int>(a)]);
  }
  return sum > 0.0 ? std::abs(towards[static_cast<int>(axis)]) / sum : 0.0;
}

/// The rectangle of the cell's corners; the whole image if the eye's plane cuts it; 0 outside.
float LayersOrder::pxOf(const SolidGrid::Cell& cell) const {
  const Box box = grid_.reachOf(cell);
  double x0 = 1.0, x1 = -1.0, y0 = 1.0, y1 = -1.0;
  int before = 0;
  for (unsigned i = 0; i < 8; ++i) {
    const glm::dvec3 p =
        glm::dvec3((i & 1U) != 0 ? box.max.x : box.min.x, (i & 2U) != 0 ? box.max.y : box.min.y,
                   (i & 4U) != 0 ? box.max.z : box.min.z) -
        camera_.origin_world;
    const double w = at(camera_.w_row, p);
    if (!(w > 0.0)) continue;
    ++before;
    const double x = at(camera_.x_row, p) / w, y = at(camera_.y_row, p) / w;
    x0 = std::min(x0, x);
    x1 = std::max(x1, x);
    y0 = std::min(y0, y);
    y1 = std::max(y1, y);
  }
  if (before == 0) return 0.0F;
  if (before < 8) return static_cast<float>(image_px_);
  const double width = std::min(x1, 1.0) - std::max(x0, -1.0);
  const double height = std::min(y1, 1.0) - std::max(y0, -1.0);
  if (!(width > 0.0) || !(height > 0.0)) return 0.0F;
  return static_cast<float>(0.25 * width * height * image_px_);
}

void LayersOrder::reach(const SolidGrid::Cell& cell, double clear) {
  LayersOrderMemory::State& state = memory_.states[grid_.indexOf(cell)];
  if (state.done) return;
  if (state.px < 0.0F) state.px = cell == eye_cell_ ? static_cast<float>(image_px_) : pxOf(cell);
  if (state.px == 0.0F || !(clear > kLeastClear)) return;
  const float before = state.clear;
  state.clear = std::min(before + static_cast<float>(clear), 1.0F);
  front_px_ += static_cast<double>(state.clear - before) * static_cast<double>(state.px);
  const Box box = grid_.boundsOf(cell);
  const glm::dvec3 away = 0.5 * (box.min + box.max) - camera_.origin_world;
  memory_.queue.push_back({state.clear, static_cast<float>(glm::dot(away, away)), cell});
  std::push_heap(memory_.queue.begin(), memory_.queue.end(), lessClear);
}

void LayersOrder::reachBehind(const SolidGrid::Cell& cell, double clear) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (const std::int32_t step : {-1, 1}) {
      const bool towards_eye = (cell[axis] - eye_cell_[axis]) * step < 0;
      SolidGrid::Cell next = cell;
      next[axis] += step;
      if (towards_eye || next[axis] < 0 || next[axis] >= grid_.counts()[axis]) continue;
      reach(next, clear * weight(next, axis));
    }
  }
}

bool LayersOrder::next(std::size_t& cell) {
  std::vector<Waiting>& queue = memory_.queue;
  while (!queue.empty()) {
    std::pop_heap(queue.begin(), queue.end(), lessClear);
    const Waiting top = queue.back();
    queue.pop_back();
    cell = grid_.indexOf(top.cell);
    LayersOrderMemory::State& state = memory_.states[cell];
    if (state.done) continue;  // it came up before, more clearly seen
    state.done = true;
    front_px_ -= static_cast<double>(state.clear) * static_cast<double>(state.px);
    const double solidity = solidity_ * static_cast<double>(grid_.solidity(cell));
    reachBehind(top.cell, static_cast<double>(state.clear) * (1.0 - solidity));
    return true;
  }
  return false;
}

double LayersOrder::frontPx() const noexcept {
  return memory_.queue.empty() ? 0.0 : std::clamp(front_px_, 0.0, image_px_);
}

}  // namespace culld
