#include "culling/occluders/strict_solids.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <tuple>

namespace culld {
namespace {

constexpr double kRowPlaces[2] = {0.53125,
                                  0.40625};  ///< of a row's width: where it is looked along

constexpr std::size_t kMostCrossings = 1U << 23U;  ///< of one part: 160 MB

/// A part's vertices move no farther than its own coordinates are rounded, times this: what else
/// the scene holds, far away, closes no gap between its walls.
constexpr double kSnapRoundings = 16.0;

/// Where a row is crossed: left of the middle of voxel `before`, right of the one before that.
struct Crossing {
  std::uint32_t y, z, before;
  std::int32_t winding;  ///< gained on the way to +x
  bool undecided;
};

/// Twice the signed area of (a, b, p) seen along x.
struct Side {
  double value, error;
};

Side sideOf(const glm::dvec3& a, const glm::dvec3& b, double y, double z) {
  const double first = (b.y - a.y) * (z - a.z), second = (b.z - a.z) * (y - a.y);
  return {first - second, 0x1p-50 * (std::abs(first) + std::abs(second)) + 1e-300};
}

/// One closed part on its way to solid voxels.
class PartVoxels {
 public:
  /// `range`: of the grid, around all of the part, from the start of a word.
  PartVoxels(const VoxelGrid& grid, const VoxelRange& range, bool mirrored)
      : grid_(grid), range_(range), mirrored_(mirrored), touched_(countsOf(range)) {
    const auto x = grid.planes(0);
    for (std::uint32_t i = range.first[0]; i < range.last[0]; ++i) {
      middles_.push_back(0.5 * x[i] + 0.5 * x[i + 1]);
    }
  }

  /// Returns the work done.
  std::uint64_t add(const WorldTriangle& t) {
    return markVoxels(t, grid_, range_, touched_) + addCrossings(t);
  }

  std::size_t crossings() const { return crossings_.size(); }

  /// Adds what is proven to `out`. True if it was anything.
  bool finish(bool two_sided, SolidVoxels& out);

 private:
  void fillRow(std::span<const Crossing> row, bool two_sided, VoxelBits& inside,
               VoxelBits& unclear) const;
  static Voxel countsOf(const VoxelRange& r) {
    return {r.last[0] - r.first[0], r.last[1] - r.first[1], r.last[2] - r.first[2]};
  }
  std::uint64_t addCrossings(const WorldTriangle& t);
  std::optional<Crossing> crossing(const WorldTriangle& t, double y, double z) const;
  double placeIn(std::size_t axis, std::uint32_t row) const {
    const auto p = grid_.planes(axis);
    return p[row] + kRowPlaces[axis - 1] * (p[row + 1] - p[row]);
  }

  const VoxelGrid& grid_;
  VoxelRange range_;
  bool mirrored_;
  VoxelBits touched_;
  std::vector<double> middles_;
  std::vector<Crossing> crossings_;
};

std::uint64_t PartVoxels::addCrossings(const WorldTriangle& t) {
  Box around;
  for (const glm::dvec3& corner : t) around.grow(corner);
  const VoxelRange rows = grid_.touching(around);
  for (std::uint32_t z = rows.first[2]; z < rows.last[2]; ++z) {
    for (std::uint32_t y = rows.first[1]; y < rows.last[1]; ++y) {
      auto found = crossing(t, placeIn(1, y), placeIn(2, z));
      if (!found) continue;
      found->y = y;
      found->z = z;
      crossings_.push_back(*found);
    }
  }
  return std::uint64_t{rows.last[1] - rows.first[1]} * (rows.last[2] - rows.first[2]);
}

/// None: the line along x through (y, z) surely passes the triangle by.
std::optional<Crossing> PartVoxels::crossing(const WorldTriangle& t, double y, double z) const {
  const Side side[3] = {sideOf(t[1], t[2], y, z), sideOf(t[2], t[0], y, z),
                        sideOf(t[0], t[1], y, z)};
  bool left = false, right = false, undecided = false;
  for (const Side& s : side) {
    if (s.value > s.error) {
      left = true;
    } else if (s.value < -s.error) {
      right = true;
    } else {
      undecided = true;
    }
  }
  if (left && right) return std::nullopt;
  if (undecided) return Crossing{0, 0, 0, 0, true};
  const double sum = side[0].value + side[1].value + side[2].value;
  const double at = t[0].x + (side[1].value / sum) * (t[1].x - t[0].x) +
                    (side[2].value / sum) * (t[2].x - t[0].x);
  const double span = std::abs(t[1].x - t[0].x) + std::abs(t[2].x - t[0].x);
  const double error =
      4.0 * (side[0].error + side[1].error + side[2].error) / std::abs(sum) * span +
      0x1p-49 * (std::abs(t[0].x) + span);
  const auto before = std::upper_bound(middles_.begin(), middles_.end(), at - error);
  const bool sure = before == middles_.end() || *before > at + error;
  const bool from_front = left == mirrored_;  // CCW seen against +x is a normal along +x
  return Crossing{0, 0, static_cast<std::uint32_t>(before - middles_.begin()), from_front ? 1 : -1,
                  !(sure && std::isfinite(error))};
}

bool PartVoxels::finish(bool two_sided, SolidVoxels& out) {
  std::sort(crossings_.begin(), crossings_.end(), [](const Crossing& a, const Crossing& b) {
    return std::tie(a.z, a.y, a.before) < std::tie(b.z, b.y, b.before);
  });
  VoxelBits inside(touched_.counts()), unclear = touched_;
  for (std::size_t first = 0; first < crossings_.size();) {
    std::size_t last = first;
    while (last < crossings_.size() && crossings_[last].z == crossings_[first].z &&
           crossings_[last].y == crossings_[first].y) {
      ++last;
    }
    fillRow(std::span(crossings_).subspan(first, last - first), two_sided, inside, unclear);
    first = last;
  }
  inside.subtract(touched_);
  if (inside.count() == 0) return false;
  out.solid.unite(inside, range_.first);
  out.unclear.unite(unclear, range_.first);
  return true;
}

/// The voxels of one row between crossings after which the part winds around them.
void PartVoxels::fillRow(std::span<const Crossing> row, bool two_sided, VoxelBits& inside,
                         VoxelBits& unclear) const {
  const std::uint32_t y = row[0].y - range_.first[1], z = row[0].z - range_.first[2];
  VoxelRange run{{0, y, z}, {inside.counts()[0], y + 1, z + 1}};
  std::int32_t sum = 0;
  bool undecided = false;
  for (const Crossing& c : row) {
    sum += c.winding;
    undecided = undecided || c.undecided;
  }
  // (The sum of a closed part is 0 wherever all is decided: the second only makes sure.)
  if (undecided || sum != 0) return unclear.fill(run);
  std::int32_t winding = 0;
  for (std::size_t i = 0; i + 1 < row.size(); ++i) {
    winding += row[i].winding;
    run.first[0] = row[i].before;
    run.last[0] = row[i + 1].before;
    if (winding >= 1 || (two_sided && winding != 0)) inside.fill(run);
  }
}

VoxelRange rangeAround(const VoxelGrid& grid, std::span<const WorldTriangle> triangles) {
  Box around;
  for (const WorldTriangle& t : triangles) {
    for (const glm::dvec3& corner : t) around.grow(corner);
  }
  return grid.touching(around);
}

/// Coordinates that differ from a plane by no more than rounding are meant to lie in it.
void snapTo(const VoxelGrid& grid, double snap, std::span<WorldTriangle> triangles) {
  for (WorldTriangle& t : triangles) {
    for (glm::dvec3& corner : t) {
      for (int axis = 0; axis < 3; ++axis) {
        const auto planes = grid.planes(static_cast<std::size_t>(axis));
        const auto near = std::lower_bound(planes.begin(), planes.end(), corner[axis] - snap);
        if (near != planes.end() && *near <= corner[axis] + snap) corner[axis] = *near;
      }
    }
  }
}

}  // namespace

SolidVoxels strictSolids(const SolidParts& parts, const VoxelGrid& grid, double snap,
                         std::uint64_t most_work) {
  SolidVoxels out{VoxelBits(grid.counts()), VoxelBits(grid.counts()), {}};
  std::uint64_t work = 0;
  std::vector<WorldTriangle> triangles;
  for (const SolidPart& part : parts.parts()) {
    if (work > most_work) break;
    if (grid.within(part.box_world).empty()) continue;  // too small to hold a voxel
    if (!(part.rounding_m <= 0.5 * snap)) continue;     // too uncertain where it is
    triangles.clear();
    parts.appendTriangles(part, triangles);
    snapTo(grid, std::min(snap, kSnapRoundings * part.rounding_m), triangles);
    const VoxelRange range = rangeAround(grid, triangles);
    VoxelRange words = range;
    words.first[0] -= words.first[0] % VoxelBits::kWordBits;
    PartVoxels voxels(grid, words, part.mirrored);
    work += range.size() / VoxelBits::kWordBits;
    bool whole = true;
    for (std::size_t t = 0; whole && t < triangles.size(); ++t) {
      work += voxels.add(triangles[t]);
      whole = work <= most_work && voxels.crossings() <= kMostCrossings;
    }
    if (!whole) {
      out.complete = false;
      continue;
    }
    if (voxels.finish(part.part->two_sided, out)) out.makers.push_back({part.object, range});
  }
  std::stable_sort(out.makers.begin(), out.makers.end(),
                   [](const SolidMaker& a, const SolidMaker& b) { return a.object < b.object; });
  return out;
}

}  // namespace culld
