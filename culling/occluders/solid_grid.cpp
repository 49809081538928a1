#include "culling/occluders/solid_grid.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/vector_relational.hpp>

namespace culld {
namespace {

constexpr double kFarShare = 0.01;  ///< of the objects, on each side: too far out for the grid

bool inGrid(const Instance& instance) {
  return instance.active() && !instance.always_kept && instance.bounds_world.finite();
}

glm::dvec3 middleOf(const Box& box) { return 0.5 * box.min + 0.5 * box.max; }

/// Where most objects are, whatever lies far away from them.
Box usualBounds(const SceneSnapshot& scene, std::size_t& objects, Box& all) {
  std::array<std::vector<double>, 3> middles;
  for (ObjectId id = 0; id < scene.objectCount(); ++id) {
    const Instance& instance = scene.instance(id);
    if (!inGrid(instance)) continue;
    all.grow(instance.bounds_world);
    for (int axis = 0; axis < 3; ++axis) {
      middles[static_cast<std::size_t>(axis)].push_back(middleOf(instance.bounds_world)[axis]);
    }
  }
  objects = middles[0].size();
  if (objects == 0) return {glm::dvec3(0.0), glm::dvec3(1.0)};
  Box usual;
  const auto cut = static_cast<std::ptrdiff_t>(kFarShare * static_cast<double>(objects));
  for (int axis = 0; axis < 3; ++axis) {
    auto& m = middles[static_cast<std::size_t>(axis)];
    std::sort(m.begin(), m.end());
    const double low = m[static_cast<std::size_t>(cut)];
    const double high = m[m.size() - 1 - static_cast<std::size_t>(cut)];
    const double margin = 0.05 * (high - low);
    usual.min[axis] = std::max(low - margin, all.min[axis]);
    usual.max[axis] = std::min(high + margin, all.max[axis]);
  }
  return usual;
}

/// Cells about as wide as high as deep.
SolidGrid::Cell countsFor(const glm::dvec3& extent, double cells) {
  const double largest = std::max({extent.x, extent.y, extent.z});
  SolidGrid::Cell counts{1, 1, 1};
  if (!(largest > 0.0) || !std::isfinite(largest)) return counts;
  const glm::dvec3 shape = glm::max(extent / largest, glm::dvec3(1e-3));
  const double scale = std::cbrt(cells / (shape.x * shape.y * shape.z));
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double n = std::floor(scale * shape[static_cast<int>(axis)]);
    counts[axis] = static_cast<std::int32_t>(std::clamp(n, 1.0, 256.0));
  }
  while (static_cast<std::uint32_t>(counts[0] * counts[1] * counts[2]) > SolidGrid::kMostCells) {
    auto& most = *std::max_element(counts.begin(), counts.end());
    most = (most + 1) / 2;
  }
  return counts;
}

}  // namespace

class SolidGridBuilder {
 public:
  SolidGridBuilder(const SceneSnapshot& scene, const OccluderSet& set, double cells_per_object)
      : scene_(scene), set_(set), cells_(std::make_shared<SolidGrid::Cells>()) {
    std::size_t objects = 0;
    cells_->bounds = usualBounds(scene, objects, cells_->all);
    const glm::dvec3 extent = cells_->bounds.max - cells_->bounds.min;
    const double wanted = std::clamp(cells_per_object * static_cast<double>(objects), 1.0,
                                     static_cast<double>(SolidGrid::kMostCells));
    cells_->counts = countsFor(extent, wanted);
    for (int axis = 0; axis < 3; ++axis) {
      cells_->side[axis] =
          extent[axis] / static_cast<double>(cells_->counts[static_cast<std::size_t>(axis)]);
    }
    grid_.cells_ = cells_;
  }

  SolidGrid build() {
    const auto count = static_cast<std::size_t>(cells_->counts[0]) *
                       static_cast<std::size_t>(cells_->counts[1]) *
                       static_cast<std::size_t>(cells_->counts[2]);
    clear_.assign(count, 1.0F);
    cells_->solidity.resize(count);
    cells_->first.assign(count + 1, 0);
    for (ObjectId id = 0; id < scene_.objectCount(); ++id) count_(id);
    for (std::size_t i = 0; i < count; ++i) {
      cells_->first[i + 1] += cells_->first[i];
      cells_->solidity[i] = 1.0F - clear_[i];
    }
    cells_->objects.resize(cells_->first[count]);
    std::vector<std::uint32_t> next(cells_->first.begin(), cells_->first.end() - 1);
    for (ObjectId id = 0; id < scene_.objectCount(); ++id) {
      forEachCell(id, [&](std::size_t i, const Box&) { cells_->objects[next[i]++] = id; });
    }
    return std::move(grid_);
  }

 private:
  void count_(ObjectId id) {
    const Instance& instance = scene_.instance(id);
    if (!inGrid(instance)) return;
    const double fill = std::min(1.0, 2.0 * set_.mesh(instance.mesh).fill);
    const bool few = forEachCell(id, [&](std::size_t i, const Box& cell) {
      ++cells_->first[i + 1];
      clear_[i] *= static_cast<float>(1.0 - fill * shareOf(instance.bounds_world, cell));
    });
    if (!few) grid_.loose_.push_back(id);
  }

  /// Of the cell's three faces, the mean share that the box would cover.
  double shareOf(const Box& box, const Box& cell) const {
    std::array<double, 3> part;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<int>(axis);
      const double low = std::max(box.min[a], cell.min[a]);
      const double high = std::min(box.max[a], cell.max[a]);
      part[axis] = cells_->side[a] > 0.0 ? std::clamp((high - low) / cells_->side[a], 0.0, 1.0) : 1;
    }
    return (part[0] * part[1] + part[1] * part[2] + part[2] * part[0]) / 3.0;
  }

  /// False, and nothing is done, if the object lies in too many cells.
  template <typename Do>
  bool forEachCell(ObjectId id, const Do& act) const {
    const Instance& instance = scene_.instance(id);
    if (!inGrid(instance)) return true;
    const SolidGrid::Cell low = grid_.cellAt(instance.bounds_world.min);
    const SolidGrid::Cell high = grid_.cellAt(instance.bounds_world.max);
    std::uint64_t count = 1;
    for (std::size_t a = 0; a < 3; ++a) count *= static_cast<std::uint64_t>(high[a] - low[a] + 1);
    if (count > SolidGrid::kMostCellsOfObject) return false;
    for (std::int32_t z = low[2]; z <= high[2]; ++z) {
      for (std::int32_t y = low[1]; y <= high[1]; ++y) {
        for (std::int32_t x = low[0]; x <= high[0]; ++x) {
          act(grid_.indexOf({x, y, z}), grid_.boundsOf({x, y, z}));
        }
      }
    }
    return true;
  }

  const SceneSnapshot& scene_;
  const OccluderSet& set_;
  std::shared_ptr<SolidGrid::Cells> cells_;
  SolidGrid grid_;
  std::vector<float> clear_;  ///< by cell: 1 - solidity
};

SolidGrid SolidGrid::of(const SceneSnapshot& scene, const OccluderSet& set,
                        double cells_per_object) {
  return SolidGridBuilder(scene, set, cells_per_object).build();
}

SolidGrid SolidGrid::edited(std::span<const ObjectId> changed) const {
  SolidGrid next = *this;
  next.loose_.insert(next.loose_.end(), changed.begin(), changed.end());
  std::sort(next.loose_.begin(), next.loose_.end());
  next.loose_.erase(std::unique(next.loose_.begin(), next.loose_.end()), next.loose_.end());
  return next;
}

std::size_t SolidGrid::indexOf(const Cell& cell) const noexcept {
  const Cell& n = cells_->counts;
  return static_cast<std::size_t>((cell[2] * n[1] + cell[1]) * n[0] + cell[0]);
}

SolidGrid::Cell SolidGrid::cellAt(const glm::dvec3& world) const noexcept {
  Cell cell{0, 0, 0};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<int>(axis);
    const double at = (world[a] - cells_->bounds.min[a]) / cells_->side[a];
    const double last = cells_->counts[axis] - 1;
    if (at > 0.0) cell[axis] = static_cast<std::int32_t>(std::min(at, last));  // NaN stays 0
  }
  return cell;
}

bool SolidGrid::contains(const glm::dvec3& world) const noexcept {
  return glm::all(glm::greaterThanEqual(world, cells_->bounds.min)) &&
         glm::all(glm::lessThanEqual(world, cells_->bounds.max));
}

Box SolidGrid::boundsOf(const Cell& cell) const noexcept {
  const glm::dvec3 low = cells_->bounds.min + glm::dvec3(cell[0], cell[1], cell[2]) * cells_->side;
  return {low, low + cells_->side};
}

Box SolidGrid::reachOf(const Cell& cell) const noexcept {
  Box box = boundsOf(cell);
  if (cells_->all.empty()) return box;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<int>(axis);
    if (cell[axis] == 0) box.min[a] = std::min(box.min[a], cells_->all.min[a]);
    if (cell[axis] == cells_->counts[axis] - 1) {
      box.max[a] = std::max(box.max[a], cells_->all.max[a]);
    }
  }
  return box;
}

std::span<const ObjectId> SolidGrid::objects(std::size_t index) const noexcept {
  const std::uint32_t first = cells_->first[index];
  return std::span(cells_->objects).subspan(first, cells_->first[index + 1] - first);
}

std::size_t SolidGrid::bytes() const noexcept {
  return cells_->solidity.capacity() * sizeof(float) +
         cells_->first.capacity() * sizeof(std::uint32_t) +
         (cells_->objects.capacity() + loose_.capacity()) * sizeof(ObjectId);
}

}  // namespace culld
