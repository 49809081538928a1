#include "culling/raster/own_triangles.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <numeric>

#include "culling/raster/nearest_plane.h"
#include "culling/raster/object_rows.h"
#include "culling/raster/occludee_kernels.h"
#include "culling/raster/triangle_blocks.h"
#include "culling/raster/triangle_setup.h"

namespace culld {
namespace {

constexpr std::uint32_t kLanes = kTriangleLanes;
constexpr std::array<float, 64> kNothingProven{};

// Nanoseconds of counted work, measured (docs/planner.md).
constexpr std::uint64_t kObjectNs = 150, kEightNs = 200, kEdgesNs = 1500, kBlockNs = 10;
constexpr std::uint64_t kLookNs = 50'000;  ///< between two looks at the clock

/// `plane` over one block.
float nearestOver(const NearestPlane& plane, std::uint32_t block_x, std::uint32_t block_y) {
  constexpr double kCells = kBlockSide;
  const double u0 = kCells * block_x, v0 = kCells * block_y;
  return plane.over(u0, u0 + kCells, v0, v0 + kCells);
}

/// `plane` over the cells of one block.
BlockNearest nearestIn(const NearestPlane& plane, std::uint32_t block_x, std::uint32_t block_y) {
  constexpr double kCells = kBlockSide;
  const double a = plane.a, b = plane.b, c = plane.c;
  const double corner =
      c + a * (kCells * block_x) + b * (kCells * block_y) + std::max(a, 0.0) + std::max(b, 0.0);
  const double terms =
      std::abs(corner) + 8.0 * (std::abs(a) + std::abs(b)) +
      0x1p-26 * (std::abs(c) + std::abs(a) * (kCells * block_x) + std::abs(b) * (kCells * block_y));
  if (!(terms < 1e37)) return {0.0F, 0.0F, 3.0e38F, plane.ceiling};
  const double slack = 0x1p-20 * terms + 1e-37;  // 16 float roundings; the kernel needs 9
  return {static_cast<float>(a), static_cast<float>(b), static_cast<float>(corner + slack),
          plane.ceiling};
}

/// The row is positive on the whole object. Its largest coordinates are all that is known of it.
bool surelyAbove(const ObjectRow& row, double error, const glm::dvec3& largest) {
  const double reach =
      std::abs(row.x) * largest.x + std::abs(row.y) * largest.y + std::abs(row.z) * largest.z;
  return row.constant - 1.01 * reach > error;
}

class OwnTriangles {
 public:
  OwnTriangles(const SheetObject& object, const CellView& view, const glm::dvec3& origin,
               DepthCells& cells)
      : object_(object),
        cells_(cells),
        grid_{static_cast<double>(view.grid.width), static_cast<double>(view.grid.height)},
        front_(view.front_sign * handedness(object.world_from_mesh)) {
    view_.rows = objectRows(view, object.world_from_mesh, origin, object.largest);
    view_.width = grid_.width;
    view_.height = grid_.height;
    view_.perspective = view.perspective;
    view_.may_be_cut =
        !surelyAbove(view_.rows.near_cut, view_.rows.error.near_cut, object.largest) ||
        !surelyAbove(view_.rows.far_cut, view_.rows.error.far_cut, object.largest);
  }

  /// False once something may be seen, or the work or the time is used up.
  bool allHidden(const Deadline& deadline, std::uint64_t most_work_ns) {
    deadline_ = &deadline;
    most_work_ns_ = most_work_ns;
    if (object_.triangles.size() / kLanes * kEightNs > most_work_ns) return false;  // in any case
    return std::all_of(object_.surfaces.begin(), object_.surfaces.end(),
                       [&](const SheetSurface& surface) { return surfaceHidden(surface); });
  }
  std::uint64_t workNs() const noexcept { return work_ns_; }
  bool outOfTime() const noexcept { return out_of_time_; }

 private:
  bool mayGoOn(std::uint64_t ns);
  bool surfaceHidden(const SheetSurface& surface);
  bool eightHidden(std::uint32_t first, std::uint32_t count, double front);
  bool cornerOpen(std::uint32_t triangle);
  bool edgesHidden(std::uint32_t triangle, float ceiling, double front);
  bool rowHidden(const TriangleBlocks& blocks, const NearestPlane& nearest,
                 const ProjectedTriangle& projected, std::uint32_t block_y);
  bool blockHidden(const TriangleBlocks& blocks, const NearestPlane& nearest,
                   const ProjectedTriangle& projected, std::uint32_t block_x,
                   std::uint32_t block_y);

  const SheetObject& object_;
  DepthCells& cells_;
  OccludeeView view_;
  GridSize grid_;
  double front_;  ///< sign of the projected area of what is seen; 0: not known
  const Deadline* deadline_ = nullptr;
  std::uint64_t work_ns_ = kObjectNs, most_work_ns_ = 0, next_look_ns_ = kLookNs;
  bool out_of_time_ = false;
  TriangleLanes lanes_{};
  TriangleRects rects_{};
  BlockTriangle part_;
};

bool OwnTriangles::mayGoOn(std::uint64_t ns) {
  work_ns_ += ns;
  if (work_ns_ > most_work_ns_) return false;
  if (work_ns_ < next_look_ns_) return true;
  next_look_ns_ += kLookNs;
  out_of_time_ = deadline_->passed();
  return !out_of_time_;
}

/// Groups in an order that hops through the surface: neighbours are hidden together, so what can be
/// seen is met sooner.
bool OwnTriangles::surfaceHidden(const SheetSurface& surface) {
  const double front = surface.double_sided ? 0.0 : front_;
  const std::uint32_t groups = (surface.triangle_count + kLanes - 1) / kLanes;
  std::uint32_t step = static_cast<std::uint32_t>(0.618 * groups) | 1U;
  while (std::gcd(step, groups) > 1) step += 2;
  std::uint64_t group = 0;
  for (std::uint32_t i = 0; i < groups; ++i, group = (group + step) % groups) {
    const auto begin = static_cast<std::uint32_t>(group) * kLanes;
    const std::uint32_t count = std::min(surface.triangle_count - begin, kLanes);
    if (!mayGoOn(kEightNs)) return false;
    if (!eightHidden(surface.first_triangle + begin, count, front)) return false;
  }
  return true;
}

bool OwnTriangles::eightHidden(std::uint32_t first, std::uint32_t count, double front) {
  for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
    const auto& corner = object_.triangles[first + std::min(lane, count - 1)];
    for (std::size_t c = 0; c < 3; ++c) {
      const glm::vec3& p = object_.positions[corner[c]];
      lanes_.coordinate[3 * c][lane] = p.x;
      lanes_.coordinate[3 * c + 1][lane] = p.y;
      lanes_.coordinate[3 * c + 2][lane] = p.z;
    }
  }
  projectTriangles(view_, lanes_, front, rects_);
  std::uint32_t seen = ~rects_.unseen & ((1U << count) - 1);
  for (; seen != 0; seen &= seen - 1) {
    const auto l = static_cast<std::uint32_t>(std::countr_zero(seen));
    const CellRect rect{rects_.x0[l], rects_.x1[l], rects_.y0[l], rects_.y1[l]};
    if (cells_.certainlyHidden(rect, rects_.nearest[l])) continue;
    if (cornerOpen(first + l) || !edgesHidden(first + l, rects_.nearest[l], front)) return false;
  }
  return true;
}

/// A guess that saves work: if a corner's cell does not hide it, edges will not either.
bool OwnTriangles::cornerOpen(std::uint32_t triangle) {
  for (const std::uint32_t corner : object_.triangles[triangle]) {
    const glm::dvec3 p(object_.positions[corner]);
    const double r = 1.0 / view_.rows.w.at(p);
    const double x = view_.rows.u.at(p) * r, y = view_.rows.v.at(p) * r;
    const double nearness = view_.rows.n.at(p) * r;
    const bool on_image = r > 0.0 && x >= 0.0 && x < view_.width && y >= 0.0 && y < view_.height;
    if (!on_image || !(nearness < 1e30)) continue;
    const auto i = static_cast<std::uint32_t>(x), j = static_cast<std::uint32_t>(y);
    if (!cells_.certainlyHidden({i, i, j, j}, static_cast<float>(nearness))) return true;
  }
  return false;
}

bool OwnTriangles::edgesHidden(std::uint32_t triangle, float ceiling, double front) {
  if (!mayGoOn(kEdgesNs)) return false;
  std::array<CellVertex, 3> p{};
  for (std::size_t c = 0; c < 3; ++c) {
    p[c] = view_.rows.at(glm::dvec3(object_.positions[object_.triangles[triangle][c]]));
  }
  const CellVertexError& error = view_.rows.error;
  const OrientedTriangle oriented = orientTriangle(p[0], p[1], p[2], error, grid_, 0);
  if (oriented.orientation == 0) return false;
  if (static_cast<double>(oriented.orientation) * front < 0.0) return true;  // turned away
  const ProjectedTriangle projected = projectTriangle(p[0], p[1], p[2], error, grid_, oriented);
  if (!projected.on_grid) return true;
  const NearestPlane nearest = nearestPlane(p, error, grid_, oriented, ceiling);
  const TriangleBlocks blocks(projected, 0);
  for (std::uint32_t y = projected.cell_y0 / kBlockSide; y <= projected.cell_y1 / kBlockSide; ++y) {
    if (!rowHidden(blocks, nearest, projected, y)) return false;
  }
  return true;
}

bool OwnTriangles::rowHidden(const TriangleBlocks& blocks, const NearestPlane& nearest,
                             const ProjectedTriangle& projected, std::uint32_t block_y) {
  const BlockSpan span = blocks.span(block_y);
  for (std::uint32_t x = span.first_touched; x < span.end_touched; ++x) {
    if (!mayGoOn(kBlockNs)) return false;
    if (!blockHidden(blocks, nearest, projected, x, block_y)) return false;
  }
  return true;
}

bool OwnTriangles::blockHidden(const TriangleBlocks& blocks, const NearestPlane& nearest,
                               const ProjectedTriangle& projected, std::uint32_t block_x,
                               std::uint32_t block_y) {
  const std::uint32_t block = cells_.grid().blockAt(block_x, block_y);
  const float least = cells_.leastNearness(block);
  if (least > nearestOver(nearest, block_x, block_y)) return true;
  if (!blocks.part(block_x, block_y, part_)) return true;
  const float* drawn = cells_.readCells(block);
  const float* nearness = drawn != nullptr ? drawn : kNothingProven.data();
  const std::uint64_t open =
      cellsNotHiding(part_, nearestIn(nearest, block_x, block_y), least, nearness);
  const CellRect cells{projected.cell_x0, projected.cell_x1, projected.cell_y0, projected.cell_y1};
  return (open & squareMask(cells, block_x * kBlockSide, block_y * kBlockSide)) == 0;
}

}  // namespace

OwnTriangleVerdict ownTrianglesHidden(const SheetObject& object, const CellView& view,
                                      const glm::dvec3& camera_origin_world,
                                      const Deadline& deadline, std::uint64_t most_work_ns,
                                      DepthCells& cells) {
  OwnTriangles test(object, view, camera_origin_world, cells);
  const bool hidden = test.allHidden(deadline, most_work_ns);
  return {hidden, test.workNs(), test.outOfTime()};
}

}  // namespace culld
