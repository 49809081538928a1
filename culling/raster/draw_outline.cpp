// Outlines to cells, tile by tile: masks of blocks, then masks of the cells of the few blocks that
// a side crosses.
#include <algorithm>
#include <bit>
#include <cmath>

#include "culling/raster/convex_outline.h"
#include "culling/raster/outline_rounding.h"

namespace culld {
namespace {

constexpr double kParts = 8.0;  ///< of a square and axis
constexpr double kTileCells = kParts * kParts;

/// A side's least and largest change from the lower corner of a cell.
double low(const SideLine& s) { return leastChange(s); }
double high(const SideLine& s) { return std::max(s.a, 0.0) + std::max(s.b, 0.0); }

/// What a side's value may lose on its way through float within a tile, and its own error (§4.6).
double marginAt(const SideLine& s, double value) { return sideMargin(s, value, 128.0); }

/// One plane of a tile whose first block lies at (x, y).
void addPlane(OutlineSquare& square, const DepthPlane& plane, double x, double y) {
  const double corner = plane.c + plane.a * x + plane.b * y;
  const double a = kParts * plane.a, b = kParts * plane.b;
  const double rise = std::abs(a) + std::abs(b);
  const double terms = std::abs(corner) + kParts * rise;
  const double slack = planeSlack(terms);
  if (!(terms < kMostPlaneTerms))
    return square.addConstant(square.depth_floor, square.depth_ceiling);
  const std::uint32_t p = square.planes++;
  square.plane_a[p] = static_cast<float>(a);
  square.plane_b[p] = static_cast<float>(b);
  square.plane_c[p] = static_cast<float>(corner + std::min(a, 0.0) + std::min(b, 0.0) - slack);
  square.plane_rise[p] = static_cast<float>(rise + 2.0 * slack);
}

void setPlanes(OutlineSquare& square, const ConvexOutline& outline, double x, double y) {
  square.planes = 0;
  for (std::uint32_t p = 0; p < outline.plane_count; ++p) {
    addPlane(square, outline.planes[p], x, y);
  }
  if (square.planes == 0) square.addConstant(square.depth_floor, square.depth_ceiling);
}

class OutlineDrawing {
 public:
  OutlineDrawing(const ConvexOutline& outline, float nearest, DepthCells& cells)
      : outline_(outline), nearest_(nearest), cells_(cells) {
    tile_.depth_floor = block_.depth_floor = outline.depth_floor;
    tile_.depth_ceiling = nearest;
  }

  void drawTile(std::uint32_t tile_x, std::uint32_t tile_y) {
    const double x = kTileCells * tile_x, y = kTileCells * tile_y;
    const std::uint32_t tile = tile_y * cells_.grid().tiles_x + tile_x;
    ++squares_;
    if (nearestInTile(x, y) <= cells_.leastOfTile(tile) || !setTileSides(x, y)) return;
    setPlanes(tile_, outline_, x, y);
    float* least = cells_.leastOfBlocks(tile);
    outlineMasks(tile_, least, masks_);
    const std::uint64_t wanted = blocksOf(tile_x, tile_y) & masks_.raisable;
    const std::uint64_t full = masks_.full & wanted, rim = masks_.some & wanted & ~full;
    for (std::uint64_t left = rim; left != 0; left &= left - 1) {
      const auto bit = static_cast<std::uint32_t>(std::countr_zero(left));
      drawBlock(tile_x * kTileSide + bit % 8, tile_y * kTileSide + bit / 8, bit, least[bit]);
    }
    if (full != 0) {
      cells_.setLeastOfTile(tile, raiseOutline(tile_, full, least));
      cells_.markBlocksRaised(tile, full);
    } else if (rim != 0) {
      cells_.forgetLeastOfTile(tile);
    }
  }

  std::uint32_t squares() const { return squares_; }

 private:
  /// About the nearness of the nearest point in the tile: it only saves work.
  float nearestInTile(double x, double y) const {
    float nearest = nearest_;
    for (std::uint32_t p = 0; p < outline_.plane_count; ++p) {
      const DepthPlane& plane = outline_.planes[p];
      const double top = plane.c + plane.a * (plane.a > 0.0 ? x + kTileCells : x) +
                         plane.b * (plane.b > 0.0 ? y + kTileCells : y);
      nearest = std::min(nearest, static_cast<float>(top));
    }
    return std::max(nearest, outline_.depth_floor);
  }

  /// The sides that do not contain all of the tile. False: no cell of it is inside all sides.
  bool setTileSides(double x, double y) {
    tile_.sides = 0;
    for (std::uint32_t s = 0; s < outline_.side_count; ++s) {
      const SideLine& side = outline_.sides[s];
      const double c = side.c + side.a * x + side.b * y, margin = marginAt(side, c);
      if (c + (kTileCells - 1.0) * high(side) + low(side) < margin) return false;
      if (c + kTileCells * low(side) >= margin) continue;
      const std::uint32_t k = tile_.sides++;
      side_of_[k] = s;
      tile_.a[k] = static_cast<float>(kParts * side.a);
      tile_.b[k] = static_cast<float>(kParts * side.b);
      tile_.c[k] = static_cast<float>(c);
      tile_.full[k] = roundedUp(margin - kParts * low(side));
      tile_.some[k] = static_cast<float>(margin - (kParts - 1.0) * high(side) - low(side));
    }
    return true;
  }

  std::uint64_t blocksOf(std::uint32_t tile_x, std::uint32_t tile_y) const {
    const CellRect& c = outline_.cells;
    return squareMask({c.x0 / kBlockSide, c.x1 / kBlockSide, c.y0 / kBlockSide, c.y1 / kBlockSide},
                      tile_x * kTileSide, tile_y * kTileSide);
  }

  /// `bit`: the block's in the masks of its tile.
  void drawBlock(std::uint32_t block_x, std::uint32_t block_y, std::uint32_t bit, float& least) {
    const double x = kParts * block_x, y = kParts * block_y;
    ++squares_;
    block_.sides = 0;
    for (std::uint32_t k = 0; k < tile_.sides; ++k) {
      if ((masks_.full_of_side[k] >> bit & 1U) != 0) continue;
      const SideLine& side = outline_.sides[side_of_[k]];
      const double c = side.c + side.a * x + side.b * y;
      const std::uint32_t n = block_.sides++;
      block_.a[n] = static_cast<float>(side.a);
      block_.b[n] = static_cast<float>(side.b);
      block_.c[n] = static_cast<float>(c);
      block_.full[n] = roundedUp(marginAt(side, c) - low(side));
    }
    const std::uint64_t covered = outlineInside(block_);
    if (covered == 0) return;
    float* nearness = cells_.cells(cells_.grid().blockAt(block_x, block_y));
    setBlockPlanes(bit);
    least = std::max(least, raiseOutline(block_, covered, nearness));
  }

  /// The tile's planes over the cells of one of its blocks. They bound whole blocks from below;
  /// a cell's corner lies up to seven eighths of the way back.
  void setBlockPlanes(std::uint32_t bit) {
    const std::uint32_t column = bit % 8, row = bit / 8;
    const auto i = static_cast<float>(column), j = static_cast<float>(row);
    block_.planes = tile_.planes;
    for (std::uint32_t p = 0; p < tile_.planes; ++p) {
      const float a = tile_.plane_a[p], b = tile_.plane_b[p];
      const float whole = a * i + (tile_.plane_c[p] + b * j);
      block_.plane_a[p] = 0.125F * a;
      block_.plane_b[p] = 0.125F * b;
      block_.plane_c[p] = whole - 0.875F * (std::min(a, 0.0F) + std::min(b, 0.0F));
    }
  }

  const ConvexOutline& outline_;
  float nearest_;
  DepthCells& cells_;
  std::uint32_t squares_ = 0;
  std::array<std::uint32_t, kMostOutlineSides> side_of_;  ///< of the tile's
  OutlineSquare tile_, block_;
  OutlineMasks masks_;
};

}  // namespace

std::uint32_t drawOutline(const ConvexOutline& outline, float nearest, DepthCells& cells) {
  OutlineDrawing drawing(outline, nearest, cells);
  const CellRect& c = outline.cells;
  constexpr std::uint32_t kSide = kBlockSide * kTileSide;
  for (std::uint32_t y = c.y0 / kSide; y <= c.y1 / kSide; ++y) {
    for (std::uint32_t x = c.x0 / kSide; x <= c.x1 / kSide; ++x) drawing.drawTile(x, y);
  }
  return drawing.squares();
}

}  // namespace culld
