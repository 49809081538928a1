// Space cut into cells with a solidity each: how likely it is that one cannot see through it (after
// Klosowski, Silva 2000, prioritized-layered projection). Departs from them: a regular grid sized
// by the number of objects instead of a Delaunay tessellation or an octree, and solidity from the
// objects' boxes instead of primitive counts. It orders and estimates; it proves nothing.
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "culling/core/box.h"
#include "culling/core/ids.h"
#include "culling/occluders/occluder_set.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

class SolidGrid {
 public:
  using Cell = std::array<std::int32_t, 3>;

  /// `cells_per_object`: about so many cells for each, 1 to kMostCells in all. Objects that lie far
  /// away from the most belong to the cells at the rim.
  /// COST: less than a microsecond per object and cell that it lies in, kMostCellsOfObject at most.
  static SolidGrid of(const SceneSnapshot& scene, const OccluderSet& set, double cells_per_object);
  /// Shares all cells: objects that were changed are loose from then on.
  SolidGrid edited(std::span<const ObjectId> changed) const;

  static constexpr std::uint32_t kMostCells = 32 * 32 * 32;
  static constexpr std::uint32_t kMostCellsOfObject = 64;

  const Cell& counts() const noexcept { return cells_->counts; }
  std::size_t size() const noexcept { return cells_->solidity.size(); }
  std::size_t indexOf(const Cell& cell) const noexcept;
  Cell cellAt(const glm::dvec3& world) const noexcept;  ///< the nearest one, if outside
  bool contains(const glm::dvec3& world) const noexcept;
  Box boundsOf(const Cell& cell) const noexcept;
  /// The same, but cells at the rim reach as far out as any object.
  Box reachOf(const Cell& cell) const noexcept;
  /// 0: empty, 1: nothing can be seen through it.
  float solidity(std::size_t index) const noexcept { return cells_->solidity[index]; }
  std::span<const ObjectId> objects(std::size_t index) const noexcept;
  /// In no cell, as they lie in too many, or were edited. Ascending.
  std::span<const ObjectId> loose() const noexcept { return loose_; }
  std::size_t bytes() const noexcept;

 private:
  friend class SolidGridBuilder;
  struct Cells {
    Cell counts{1, 1, 1};
    Box bounds, all;  ///< of the cells, and of all objects
    glm::dvec3 side{1.0};
    std::vector<float> solidity;
    std::vector<std::uint32_t> first;  ///< by cell, and one more
    std::vector<ObjectId> objects;
  };
  std::shared_ptr<const Cells> cells_;
  std::vector<ObjectId> loose_;
};

}  // namespace culld
