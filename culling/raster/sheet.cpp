#include "culling/raster/sheet.h"

#include <algorithm>

#include "culling/raster/object_rows.h"

namespace culld {
namespace {

constexpr std::uint32_t kNoSlot = 0xFFFFFFFFU;
constexpr std::uint32_t kGivenUp = 0xFFFFFFFEU;
constexpr std::uint32_t kNoPartner = 0xFFFFFFFFU;

// Work is counted in blocks; a triangle's or eight vertices' setup costs about as much as one.
constexpr std::uint32_t kWorkPerLook = 1024;  ///< between two looks at the clock, some 50 us
constexpr std::uint64_t kMostLayers = 64;     ///< an object that covers the image more often stops
constexpr std::size_t kVerticesPerSlice = 2048;

}  // namespace

void SheetRasterizer::transform(const SheetObject& object, const CellView& view,
                                const glm::dvec3& origin) {
  const ObjectRows rows = objectRows(view, object.world_from_mesh, origin, object.largest);
  error_ = rows.error;
  vertices_.resize(object.positions.size());
  for (std::size_t first = 0; first < vertices_.size(); first += kVerticesPerSlice) {
    if (!mayGoOn(kVerticesPerSlice / 8)) return;
    const std::size_t end = std::min(first + kVerticesPerSlice, vertices_.size());
    for (std::size_t i = first; i < end; ++i) {
      vertices_[i] = rows.at(glm::dvec3(object.positions[i]));
    }
  }
}

void SheetRasterizer::orient(const SheetObject& object, double front_sign) {
  orientation_.assign(object.triangles.size(), 0);
  oriented_.clear();
  for (const SheetSurface& surface : object.surfaces) {
    for (std::uint32_t i = 0; i < surface.triangle_count; ++i) {
      if (!mayGoOn(1)) return;
      const std::uint32_t t = surface.first_triangle + i;
      const auto& corner = object.triangles[t];
      const int wanted = surface.double_sided ? 0 : (front_sign > 0.0 ? 1 : -1);
      const OrientedTriangle oriented = orientTriangle(vertices_[corner[0]], vertices_[corner[1]],
                                                       vertices_[corner[2]], error_, grid_, wanted);
      if (oriented.orientation == 0) continue;
      orientation_[t] = static_cast<std::int8_t>(oriented.orientation);
      oriented_.push_back(oriented);
    }
  }
}

/// False once the object or the time is used up: what is drawn of a sheet then proves nothing.
bool SheetRasterizer::mayGoOn(std::uint32_t work) {
  if (stopped_) return false;
  if (work_to_look_ <= work) {
    work_to_look_ = kWorkPerLook;
    out_of_time_ = deadline_->passed();
  } else {
    work_to_look_ -= work;
  }
  stopped_ = out_of_time_ || work_left_ <= work;
  work_left_ -= std::min<std::uint64_t>(work, work_left_);
  return !stopped_;
}

/// Grows before it registers: an exception on the way leaves nothing half done.
std::uint32_t SheetRasterizer::newSlot(std::uint32_t block) {
  const auto slot = static_cast<std::uint32_t>(touched_.size());
  if (blocks_.size() <= slot) blocks_.emplace_back();
  touched_.push_back(block);
  return slot;
}

SheetBlock& SheetRasterizer::sheetBlock(std::uint32_t block) {
  std::uint32_t& slot = slot_of_block_[block];
  if (slot == kGivenUp) return scrap_;
  if (slot == kNoSlot) {
    slot = newSlot(block);
    blocks_[slot].clear();
  }
  return blocks_[slot];
}

/// The sheet can bring nothing more here than the block already has. Leaving a whole block out of a
/// sheet is sound: every cell is proven by itself.
void SheetRasterizer::giveUp(std::uint32_t block) {
  if (slot_of_block_[block] == kNoSlot) newSlot(block);
  slot_of_block_[block] = kGivenUp;
}

void SheetRasterizer::fillBlock(std::uint32_t block, float farthest, DepthCells& cells) {
  // The sheet is nowhere nearer than this triangle, which is one of it.
  if (farthest > cells.leastNearness(block)) cells.setLeastNearness(block, farthest);
  giveUp(block);
}

void SheetRasterizer::drawBlock(const TriangleBlocks& blocks, std::uint32_t block_x,
                                std::uint32_t block_y, float nearest, DepthCells& cells) {
  const std::uint32_t block = cells.grid().blockAt(block_x, block_y);
  const float least = cells.leastNearness(block);
  // Nothing of this object can raise the block: leave it out for all its triangles.
  if (least >= nearest) return;
  if (!whole_ && blocks.nearest(block_x, block_y) <= least) {
    giveUp(block);
  } else if (blocks.part(block_x, block_y, part_)) {
    addTriangle(part_, sheetBlock(block), cells.cells(block));
  }
}

void SheetRasterizer::drawTriangle(const SheetObject& object, std::uint32_t triangle,
                                   const OrientedTriangle& oriented, DepthCells& cells) {
  const auto& corner = object.triangles[triangle];
  const ProjectedTriangle projected = projectTriangle(
      vertices_[corner[0]], vertices_[corner[1]], vertices_[corner[2]], error_, grid_, oriented);
  if (!projected.on_grid && !projected.reaches_grid) return;
  std::uint32_t net_edges = 0;
  for (std::uint32_t e = 0; e < 3; ++e) {
    const std::uint32_t partner = object.partners[3 * triangle + e];
    const bool inner = partner != kNoPartner && orientation_[partner / 3] == oriented.orientation;
    if (!inner) net_edges |= 1U << e;
  }
  const bool has_rim = net_edges != 0 || projected.side_count > 3;
  if (projected.reaches_grid && has_rim) rims_.push_back({projected, net_edges});
  if (!projected.on_grid) return;
  const TriangleBlocks blocks(projected, net_edges);
  for (std::uint32_t y = projected.cell_y0 / kBlockSide; y <= projected.cell_y1 / kBlockSide; ++y) {
    const BlockSpan span = blocks.span(y);
    if (!mayGoOn(1 + span.end_touched - std::min(span.first_touched, span.end_touched))) return;
    for (std::uint32_t x = span.first_touched; x < span.first_filled; ++x) {
      drawBlock(blocks, x, y, object.nearest, cells);
    }
    for (std::uint32_t x = span.first_filled; x < span.end_filled; ++x) {
      fillBlock(cells.grid().blockAt(x, y), blocks.farthest(x, y), cells);
    }
    for (std::uint32_t x = span.end_filled; x < span.end_touched; ++x) {
      drawBlock(blocks, x, y, object.nearest, cells);
    }
  }
}

/// Where the net edges of a moving sheet may come to. After all triangles: blocks that hold nothing
/// of the sheet by then need no rim.
void SheetRasterizer::drawRims(const DepthCells& cells) {
  for (const Rim& rim : rims_) {
    const ProjectedTriangle& t = rim.triangle;
    const TriangleBlocks blocks(t, rim.net_edges);
    for (std::uint32_t y = t.reach_y0 / kBlockSide; y <= t.reach_y1 / kBlockSide; ++y) {
      const BlockSpan span = blocks.rimSpan(y);
      if (!mayGoOn(1 + span.end_touched - std::min(span.first_touched, span.end_touched))) return;
      for (std::uint32_t x = span.first_touched; x < span.end_touched; ++x) {
        const std::uint32_t slot = slot_of_block_[cells.grid().blockAt(x, y)];
        if (slot == kNoSlot || slot == kGivenUp) continue;
        if (blocks.rimPart(x, y, part_)) blocks_[slot].rim |= rimCells(part_);
      }
    }
  }
}

void SheetRasterizer::finish(DepthCells& cells) {
  for (std::size_t slot = 0; slot < touched_.size(); ++slot) {
    const std::uint32_t block = touched_[slot];
    const SheetBlock& sheet = blocks_[slot];
    const bool no_sheet = stopped_ || slot_of_block_[block] == kGivenUp;
    if (no_sheet && !cells.used(block)) continue;
    const std::uint64_t covered = no_sheet ? 0 : sheet.sampled & ~sheet.rim;
    const float least = raiseCells(covered, sheet.farthest.data(), cells.cells(block));
    cells.setLeastNearness(block, std::max(cells.leastNearness(block), least));
  }
  forgetTouched();
}

void SheetRasterizer::forgetTouched() noexcept {
  for (const std::uint32_t block : touched_) slot_of_block_[block] = kNoSlot;
  touched_.clear();
}

std::uint32_t SheetRasterizer::drawTriangles(const SheetObject& object, DepthCells& cells) {
  std::uint32_t drawn = 0;
  for (const SheetSurface& surface : object.surfaces) {
    for (std::uint32_t i = 0; i < surface.triangle_count && !stopped_; ++i) {
      const std::uint32_t t = surface.first_triangle + i;
      if (orientation_[t] == 0) continue;
      drawTriangle(object, t, oriented_[drawn], cells);
      ++drawn;
    }
  }
  return drawn;
}

DrawnSheet SheetRasterizer::draw(const SheetObject& object, const CellView& view,
                                 const glm::dvec3& camera_origin_world, const Deadline& deadline,
                                 DepthCells& cells) {
  const double front_sign = view.front_sign * handedness(object.world_from_mesh);
  if (front_sign == 0.0) return {};  // front and back cannot be told apart: nothing blocks
  forgetTouched();                   // of a draw that an exception ended
  grid_ = {static_cast<double>(view.grid.width), static_cast<double>(view.grid.height)};
  if (slot_of_block_.size() < view.grid.blocks()) {
    slot_of_block_.resize(view.grid.blocks(), kNoSlot);
  }
  deadline_ = &deadline;
  const std::uint64_t most_work =
      kMostLayers * view.grid.blocks() + object.positions.size() / 8 + object.triangles.size();
  work_left_ = most_work;
  work_to_look_ = 0;
  stopped_ = out_of_time_ = false;
  transform(object, view, camera_origin_world);
  if (!stopped_) orient(object, front_sign);
  rims_.clear();
  const std::uint32_t drawn = drawTriangles(object, cells);
  drawRims(cells);
  finish(cells);
  return {drawn, most_work - work_left_, out_of_time_};
}

std::size_t SheetRasterizer::bytes() const noexcept {
  return vertices_.capacity() * sizeof(CellVertex) + orientation_.capacity() +
         oriented_.capacity() * sizeof(OrientedTriangle) +
         slot_of_block_.capacity() * sizeof(std::uint32_t) +
         blocks_.capacity() * sizeof(SheetBlock) + rims_.capacity() * sizeof(Rim) +
         touched_.capacity() * sizeof(std::uint32_t);
}

}  // namespace culld
