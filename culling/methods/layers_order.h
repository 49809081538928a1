// In which order method `layers` projects its cells: outward from the eye, always the one of the
// front that is seen most clearly. An estimate throughout; nothing is hidden by it.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/core/camera.h"
#include "culling/occluders/solid_grid.h"

namespace culld {

/// Buffers kept from frame to frame for their memory only.
struct LayersOrderMemory {
  struct Waiting {
    float clear;      ///< when it was pushed; it may have grown since
    float distance2;  ///< from the eye, metres^2
    SolidGrid::Cell cell;
  };
  struct State {
    float clear = 0.0F;  ///< share of the sight to the cell that nothing blocks
    float px = -1.0F;    ///< of the image that it may cover; < 0: not asked yet
    bool done = false;
  };
  std::vector<Waiting> queue;  ///< a heap, clearest on top
  std::vector<State> states;   ///< by cell
};

class LayersOrder {
 public:
  /// `solidity`: weight of the cells' own. 0: all count as empty, so that the nearest comes first.
  /// REQUIRES: a perspective camera. Keeps references.
  LayersOrder(const SolidGrid& grid, const Camera& camera, double solidity,
              LayersOrderMemory& memory);

  /// The index of the next cell; false: none is left.
  bool next(std::size_t& cell);
  /// Pixels through which what has not been projected may be seen: over the cells of the front, the
  /// image each may cover times how clearly it is seen.
  double frontPx() const noexcept;

 private:
  void start();
  void reach(const SolidGrid::Cell& cell, double clear);
  void reachBehind(const SolidGrid::Cell& cell, double clear);
  double weight(const SolidGrid::Cell& cell, std::size_t axis) const;
  float pxOf(const SolidGrid::Cell& cell) const;

  const SolidGrid& grid_;
  const Camera& camera_;
  double solidity_;
  LayersOrderMemory& memory_;
  SolidGrid::Cell eye_cell_;       ///< or the nearest one
  std::array<bool, 3> outside_{};  ///< along which axes the eye is beside the grid
  double image_px_, front_px_ = 0.0;
};

}  // namespace culld
