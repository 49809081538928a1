// The contour of a piece from where one stands: the edges between faces that turn to the eye and
// faces that do not, or the rim.
#pragma once
#include <cstdint>

#include "culling/core/convex_piece.h"

namespace culld {

enum class EdgeRole : std::uint8_t {
  kAway,      ///< between faces that turn away
  kInner,     ///< between two that turn to the eye
  kForward,   ///< of the contour: runs CCW around what turns to the eye
  kBackward,  ///< the other way around it
};

/// `front`: bit f says that face f turns to the eye.
inline EdgeRole roleOf(const PieceEdge& edge, std::uint64_t front) noexcept {
  const bool left = (front >> edge.left & 1U) != 0;
  const bool right = edge.right != kNoFace && (front >> edge.right & 1U) != 0;
  if (left && right) return EdgeRole::kInner;
  if (left) return EdgeRole::kForward;
  return right ? EdgeRole::kBackward : EdgeRole::kAway;
}

}  // namespace culld
