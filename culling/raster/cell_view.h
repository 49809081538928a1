// The image as the rasterizer sees it: a grid of square cells, independent of the client's pixels.
// The exact visible set knows no pixels, so any grid is sound; a finer one leaves out more.
#pragma once
#include <cstdint>
#include <glm/vec4.hpp>
#include <limits>

#include "culling/core/camera.h"
#include "culling/raster/eye_motion.h"

namespace culld {

inline constexpr std::uint32_t kBlockSide = 8;  ///< cells per block and axis: 64 bits of a mask
inline constexpr std::uint32_t kTileSide = 8;   ///< blocks per tile and axis: the same again

struct CellGrid {
  std::uint32_t width = 0, height = 0;       ///< cells
  std::uint32_t blocks_x = 0, blocks_y = 0;  ///< blocks, the last ones may stick out
  std::uint32_t tiles_x = 0, tiles_y = 0;    ///< tiles, the last ones may stick out further
  std::uint32_t tiles() const noexcept { return tiles_x * tiles_y; }
  /// Places for blocks. Those of a tile follow each other, 64 in every tile, also past the image.
  std::uint32_t blocks() const noexcept { return tiles() * kTileSide * kTileSide; }
  std::uint32_t tileAt(std::uint32_t block_x, std::uint32_t block_y) const noexcept {
    return block_y / kTileSide * tiles_x + block_x / kTileSide;
  }
  std::uint32_t blockAt(std::uint32_t block_x, std::uint32_t block_y) const noexcept {
    const std::uint32_t within = block_y % kTileSide * kTileSide + block_x % kTileSide;
    return tileAt(block_x, block_y) * kTileSide * kTileSide + within;
  }
};

CellGrid gridOf(std::uint32_t width, std::uint32_t height) noexcept;
/// The camera's image size, scaled so that its longer side is within [256, 1280] cells.
CellGrid gridFor(const Camera& camera) noexcept;

/// Rows on (p_world - origin_world, 1). A point lies at cell coordinates (u / w, v / w), which are
/// within [0, width] x [0, height] on the image; nearness is n / w (Camera::near_row);
/// near_cut and far_cut are >= 0 between the clip planes z = -w and z = +w.
struct CellView {
  CellGrid grid;
  glm::dvec4 u{0.0}, v{0.0}, w{0.0}, n{0.0}, near_cut{0.0}, far_cut{0.0};
  bool perspective = true;
  /// Sign of the projected area of a triangle that turns its front (CCW side) to the eye; 0 if the
  /// camera is so flat that this cannot be told, then nothing blocks.
  double front_sign = 1.0;
  bool moves = false;  ///< made for a motion bound
  EyeMotion motion;    ///< an orthographic image does not change with the eye
  /// For an eye that moves: what is nearer than this may be on the image from elsewhere though it
  /// is beside the grid, and what is behind it by less than `behind_m`, too.
  double beside = std::numeric_limits<double>::infinity();
  double behind_m = 0.0;
};

/// GUARANTEES: for a camera with a motion bound the view shows what any of its poses sees, from
/// their eyes but in the camera's own orientation, on a wider grid of cells about as large;
/// blockers are cut where a near plane of any pose may cut them. REQUIRES: holdsInMotion(camera).
CellView cellView(const Camera& camera, const CellGrid& grid) noexcept;

/// False: the camera may turn too far, or it is orthographic and turns. No such view exists.
bool holdsInMotion(const Camera& camera) noexcept;

}  // namespace culld
