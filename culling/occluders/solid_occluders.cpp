#include "culling/occluders/solid_occluders.h"

#include <algorithm>
#include <utility>

#include "culling/occluders/solid_boxes.h"
#include "culling/scene/scene_builder.h"

namespace culld {
namespace {

/// More boxes for an object that made voxels solid are more work than the object itself.
constexpr std::size_t kBoxesOfObject = 2;

/// From -1 to 1 along each axis.
Mesh cube() {
  RawSurface surface;
  for (std::uint32_t corner = 0; corner < 8; ++corner) {
    surface.positions.emplace_back((corner & 1U) != 0 ? 1.0F : -1.0F,
                                   (corner & 2U) != 0 ? 1.0F : -1.0F,
                                   (corner & 4U) != 0 ? 1.0F : -1.0F);
  }
  surface.indices = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                     2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  return makeMesh({surface});
}

Box shrunk(const Box& box, double by) {
  return {box.min + glm::dvec3(by), box.max - glm::dvec3(by)};
}

std::array<double, 12> cubeTo(const Box& box) {
  const glm::dvec3 middle = 0.5 * box.min + 0.5 * box.max, half = 0.5 * (box.max - box.min);
  return {half.x, 0, 0, middle.x, 0, half.y, 0, middle.y, 0, 0, half.z, middle.z};
}

bool meet(const VoxelRange& a, const VoxelRange& b) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (a.last[axis] <= b.first[axis] || b.last[axis] <= a.first[axis]) return false;
  }
  return true;
}

/// REQUIRES: sorted by object.
std::size_t objectsOf(std::span<const SolidMaker> makers) {
  std::size_t objects = 0;
  for (std::size_t i = 0; i < makers.size(); ++i) {
    if (i == 0 || makers[i].object != makers[i - 1].object) ++objects;
  }
  return objects;
}

/// The smallest grid there is, for scenes in which nothing is closed.
VoxelGrid noGrid() { return VoxelGrid({std::vector{0.0, 1.0}, {0.0, 1.0}, {0.0, 1.0}}); }

}  // namespace

Result<SolidOccluders> SolidOccluders::of(const SceneSnapshot& scene, const SolidLimits& limits) {
  const SolidParts parts = SolidParts::of(scene);
  Box world;
  for (const SolidPart& part : parts.parts()) world.grow(part.box_world);
  SolidOccluders out;
  if (world.empty()) {
    const VoxelGrid grid = noGrid();
    out.baked_ = std::make_shared<const Baked>(Baked{grid, VoxelBits(grid.counts()), {}, 0.0});
    return out.made({});
  }
  const double snap = voxelSnap(world);
  VoxelGrid grid = voxelGridFor(parts, world, limits.voxels);
  SolidVoxels voxels = strictSolids(parts, grid, snap, limits.most_work);
  const std::size_t most = std::min(limits.most_boxes, kBoxesOfObject * objectsOf(voxels.makers));
  std::vector<VoxelRange> ranges = solidBoxes(grid, voxels.solid, most);
  voxels.unclear.unite(voxels.solid, {0, 0, 0});
  out.baked_ = std::make_shared<const Baked>(
      Baked{std::move(grid), std::move(voxels.unclear), std::move(voxels.makers), snap});
  return out.made(std::move(ranges));
}

/// With boxes for these ranges, pulled in by what rounding may have moved (solids.md §2).
Result<SolidOccluders> SolidOccluders::made(std::vector<VoxelRange> ranges) const {
  SolidOccluders out;
  out.baked_ = baked_;
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(cube());
  for (const VoxelRange& range : ranges) {
    const Box box = shrunk(baked_->grid.boundsOf(range), 4.0 * baked_->snap);
    if (box.empty()) continue;
    builder.addInstance(mesh, cubeTo(box), static_cast<std::uint32_t>(out.boxes_.size()));
    out.boxes_.push_back(box);
    out.ranges_.push_back(range);
  }
  const SnapshotPtr scene = builder.finish();
  Result<PreparedBoxes> drawn = PreparedBoxes::of(scene);
  if (!drawn) return std::move(drawn).error();
  out.drawn_ = std::make_shared<const PreparedBoxes>(std::move(drawn).value());
  out.occluders_ = std::make_shared<const OccluderSet>(OccluderSet::of(*scene));
  return out;
}

Result<SolidOccluders> SolidOccluders::without(std::span<const ObjectId> changed) const {
  std::vector<VoxelRange> lost;
  for (const ObjectId id : changed) {
    const std::vector<SolidMaker>& makers = baked_->makers;
    auto maker = std::lower_bound(makers.begin(), makers.end(), id,
                                  [](const SolidMaker& m, ObjectId of) { return m.object < of; });
    for (; maker != makers.end() && maker->object == id; ++maker) lost.push_back(maker->range);
  }
  if (lost.empty()) return *this;
  std::vector<VoxelRange> kept = ranges_;
  std::erase_if(kept, [&](const VoxelRange& range) {
    return std::any_of(lost.begin(), lost.end(),
                       [&](const VoxelRange& l) { return meet(l, range); });
  });
  return made(std::move(kept));
}

bool SolidOccluders::clear(const Box& world) const noexcept {
  const Box grown = shrunk(world, -4.0 * baked_->snap);
  return !baked_->not_clear.any(baked_->grid.touching(grown));
}

std::size_t SolidOccluders::bytes() const noexcept {
  return baked_->not_clear.bytes() + baked_->makers.size() * sizeof(SolidMaker) +
         baked_->grid.bytes() + boxes_.size() * (sizeof(Box) + sizeof(VoxelRange)) +
         drawn_->bytes() + drawn_->scene()->bytes() + occluders_->bytes();
}

}  // namespace culld
