// How far the eye of a perspective camera may move while what is proven must go on holding
// (docs/error-model/motion.md). Seen from there, all of a scene moves together, the other way.
#pragma once
#include <array>

namespace culld {

struct EyeMotion {
  bool still = true;
  /// CellView's rows u, v, w without their constants, times the radius of the bound.
  std::array<double, 3> u{}, v{}, w{};
  /// At least the rows' lengths: no point's w changes by more than w_length.
  double u_length = 0.0, v_length = 0.0, w_length = 0.0;
};

}  // namespace culld
