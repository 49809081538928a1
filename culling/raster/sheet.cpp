#include "culling/raster/sheet.h"

#include <algorithm>
#include <cmath>

namespace culld {
namespace {

constexpr std::uint32_t kNoSlot = 0xFFFFFFFFU;
constexpr std::uint32_t kGivenUp = 0xFFFFFFFEU;
constexpr std::uint32_t kNoPartner = 0xFFFFFFFFU;

/// One row of mesh space -> cells, and the bound on its rounding error over the object.
struct ObjectRow {
  double x, y, z, constant, error;
};

/// row . (world_from_mesh p - origin, 1) as a row on p. The 16 units of the error bound cover the
/// product (at most 9 roundings per term) and the four of its evaluation (docs/error-model.md
/// §4.1).
ObjectRow objectRow(const glm::dvec4& row, const std::array<double, 12>& m,
                    const glm::dvec3& offset, const glm::dvec3& largest) {
  const auto column = [&](std::size_t j) {
    return row.x * m[j] + row.y * m[4 + j] + row.z * m[8 + j];
  };
  const auto reach = [&](std::size_t j) {
    return std::abs(row.x * m[j]) + std::abs(row.y * m[4 + j]) + std::abs(row.z * m[8 + j]);
  };
  ObjectRow out{};
  out.x = column(0);
  out.y = column(1);
  out.z = column(2);
  out.constant = row.x * offset.x + row.y * offset.y + row.z * offset.z + row.w;
  const double terms = reach(0) * largest.x + reach(1) * largest.y + reach(2) * largest.z +
                       std::abs(row.x * offset.x) + std::abs(row.y * offset.y) +
                       std::abs(row.z * offset.z) + std::abs(row.w);
  out.error = 16.0 * 0x1p-53 * terms;
  return out;
}

/// Sign of the linear part's determinant: -1 mirrors, 0 is flat or so nearly flat that rounding
/// could decide. Six products of three and five sums: 8 units cover them.
double handedness(const std::array<double, 12>& m) {
  const double a = m[0] * m[5] * m[10], b = m[1] * m[6] * m[8], c = m[2] * m[4] * m[9];
  const double d = m[2] * m[5] * m[8], e = m[1] * m[4] * m[10], f = m[0] * m[6] * m[9];
  const double det = (a + b + c) - (d + e + f);
  const double terms =
      std::abs(a) + std::abs(b) + std::abs(c) + std::abs(d) + std::abs(e) + std::abs(f);
  if (!(std::abs(det) > 8.0 * 0x1p-53 * terms + 1e-280)) return 0.0;
  return det > 0.0 ? 1.0 : -1.0;
}

double at(const ObjectRow& row, const glm::dvec3& p) {
  return row.x * p.x + row.y * p.y + row.z * p.z + row.constant;
}

}  // namespace

void SheetRasterizer::transform(const SheetObject& object, const CellView& view,
                                const glm::dvec3& origin) {
  const std::array<double, 12>& m = object.world_from_mesh;
  const glm::dvec3 offset = glm::dvec3(m[3], m[7], m[11]) - origin;
  const auto row = [&](const glm::dvec4& r) { return objectRow(r, m, offset, object.largest); };
  const ObjectRow u = row(view.u), v = row(view.v), w = row(view.w), n = row(view.n),
                  near_cut = row(view.near_cut), far_cut = row(view.far_cut);
  error_ = {u.error,        v.error,      w.error, view.perspective ? 0.0 : n.error,
            near_cut.error, far_cut.error};
  vertices_.resize(object.positions.size());
  for (std::size_t i = 0; i < vertices_.size(); ++i) {
    const glm::dvec3 p(object.positions[i]);
    vertices_[i] = {at(u, p), at(v, p), at(w, p), at(n, p), at(near_cut, p), at(far_cut, p)};
  }
}

void SheetRasterizer::orient(const SheetObject& object, double front_sign) {
  orientation_.assign(object.triangles.size(), 0);
  for (const SheetSurface& surface : object.surfaces) {
    for (std::uint32_t i = 0; i < surface.triangle_count; ++i) {
      const std::uint32_t t = surface.first_triangle + i;
      const auto& corner = object.triangles[t];
      const int sign = certainOrientation(vertices_[corner[0]], vertices_[corner[1]],
                                          vertices_[corner[2]], error_, grid_);
      if (surface.double_sided || sign * front_sign > 0.0)
        orientation_[t] = static_cast<std::int8_t>(sign);
    }
  }
}

SheetBlock& SheetRasterizer::sheetBlock(std::uint32_t block) {
  std::uint32_t& slot = slot_of_block_[block];
  if (slot == kGivenUp) return scrap_;
  if (slot == kNoSlot) {
    slot = static_cast<std::uint32_t>(touched_.size());
    touched_.push_back(block);
    if (blocks_.size() <= slot) blocks_.emplace_back();
    blocks_[slot].clear();
  }
  return blocks_[slot];
}

/// The sheet can bring nothing more here than the block already has. Leaving a whole block out of a
/// sheet is sound: every cell is proven by itself.
void SheetRasterizer::giveUp(std::uint32_t block) {
  if (slot_of_block_[block] == kNoSlot) touched_.push_back(block);
  if (touched_.size() > blocks_.size()) blocks_.emplace_back();
  slot_of_block_[block] = kGivenUp;
}

void SheetRasterizer::fillBlock(std::uint32_t block, float farthest, DepthCells& cells) {
  // The sheet is nowhere nearer than this triangle, which is one of it.
  cells.setLeastNearness(block, std::max(cells.leastNearness(block), farthest));
  giveUp(block);
}

void SheetRasterizer::drawBlock(const TriangleBlocks& blocks, std::uint32_t block_x,
                                std::uint32_t block_y, float nearest, DepthCells& cells) {
  const std::uint32_t block = block_y * cells.grid().blocks_x + block_x;
  const float least = cells.leastNearness(block);
  // Nothing of this object can raise the block: leave it out for all its triangles.
  if (least >= nearest) return;
  if (blocks.nearest(block_x, block_y) <= least) {
    giveUp(block);
  } else if (blocks.part(block_x, block_y, part_)) {
    addTriangle(part_, sheetBlock(block), cells.cells(block));
  }
}

void SheetRasterizer::drawTriangle(const SheetObject& object, std::uint32_t triangle,
                                   DepthCells& cells) {
  const auto& corner = object.triangles[triangle];
  const int sign = orientation_[triangle];
  const ProjectedTriangle projected = projectTriangle(vertices_[corner[0]], vertices_[corner[1]],
                                                      vertices_[corner[2]], error_, grid_, sign);
  if (!projected.on_grid) return;
  std::uint32_t net_edges = 0;
  for (std::uint32_t e = 0; e < 3; ++e) {
    const std::uint32_t partner = object.partners[3 * triangle + e];
    const bool inner = partner != kNoPartner && orientation_[partner / 3] == sign;
    if (!inner) net_edges |= 1U << e;
  }
  const TriangleBlocks blocks(projected, net_edges);
  for (std::uint32_t y = projected.cell_y0 / kBlockSide; y <= projected.cell_y1 / kBlockSide; ++y) {
    const BlockSpan span = blocks.span(y);
    for (std::uint32_t x = span.first_touched; x < span.first_filled; ++x) {
      drawBlock(blocks, x, y, object.nearest, cells);
    }
    for (std::uint32_t x = span.first_filled; x < span.end_filled; ++x) {
      fillBlock(y * cells.grid().blocks_x + x, blocks.farthest(x, y), cells);
    }
    for (std::uint32_t x = span.end_filled; x < span.end_touched; ++x) {
      drawBlock(blocks, x, y, object.nearest, cells);
    }
  }
}

void SheetRasterizer::finish(DepthCells& cells) {
  for (std::size_t slot = 0; slot < touched_.size(); ++slot) {
    const std::uint32_t block = touched_[slot];
    const SheetBlock& sheet = blocks_[slot];
    const bool given_up = slot_of_block_[block] == kGivenUp;
    slot_of_block_[block] = kNoSlot;
    if (given_up && !cells.used(block)) continue;
    const std::uint64_t covered = given_up ? 0 : sheet.sampled & ~sheet.rim;
    const float least = raiseCells(covered, sheet.farthest.data(), cells.cells(block));
    cells.setLeastNearness(block, std::max(cells.leastNearness(block), least));
  }
  touched_.clear();
}

std::uint32_t SheetRasterizer::draw(const SheetObject& object, const CellView& view,
                                    const glm::dvec3& camera_origin_world, DepthCells& cells) {
  const double front_sign = view.front_sign * handedness(object.world_from_mesh);
  if (front_sign == 0.0) return 0;  // front and back cannot be told apart: nothing blocks
  grid_ = {static_cast<double>(view.grid.width), static_cast<double>(view.grid.height)};
  if (slot_of_block_.size() < view.grid.blocks())
    slot_of_block_.resize(view.grid.blocks(), kNoSlot);
  transform(object, view, camera_origin_world);
  orient(object, front_sign);
  std::uint32_t drawn = 0;
  for (const SheetSurface& surface : object.surfaces) {
    for (std::uint32_t i = 0; i < surface.triangle_count; ++i) {
      const std::uint32_t t = surface.first_triangle + i;
      if (orientation_[t] == 0) continue;
      drawTriangle(object, t, cells);
      ++drawn;
    }
  }
  finish(cells);
  return drawn;
}

std::size_t SheetRasterizer::bytes() const noexcept {
  return vertices_.capacity() * sizeof(CellVertex) + orientation_.capacity() +
         slot_of_block_.capacity() * sizeof(std::uint32_t) +
         blocks_.capacity() * sizeof(SheetBlock) + touched_.capacity() * sizeof(std::uint32_t);
}

}  // namespace culld
