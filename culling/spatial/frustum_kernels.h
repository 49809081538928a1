// The inner loop of frustum culling: eight boxes of a WideNode against up to six planes. Equal bits
// on every SIMD target and in the scalar reference: the same roundings in the same order, no fused
// multiply-add. Why a box that may be seen is never called outside: docs/error-model/frustum.md.
#pragma once
#include <cstdint>

namespace culld {

inline constexpr std::uint32_t kMaxPlanes = 6;

/// K of the error model: margin = K * sum(|terms|) + slack, K = 8 units in the last place (2^-24).
inline constexpr float kFrustumMargin = 0x1p-21F;

/// A plane as one node sees it: value(offset) = base + dot(normal, offset), >= 0 on the inner side.
struct NodePlane {
  float normal[3];
  float base;
  float slack;  ///< what the margin owes to everything rounded before the kernel; may be +inf
};

struct NodePlanes {
  NodePlane plane[kMaxPlanes];
  std::uint32_t count = 0;
  /// A camera that may turn: each plane moves by up to turn * (distance from the eye) + turn_slack.
  float eye_to_node[3] = {0, 0, 0};
  float turn = 0;
  float turn_slack = 0;
};

struct LaneBits {
  std::uint32_t outside = 0;         ///< bit l: box l is provably outside some plane
  std::uint32_t inside[kMaxPlanes];  ///< bit l: box l is provably on the inner side of plane p
};

/// `offsets`: WideNode::offsets, six rows of eight. Lanes with NaN or infinities are in no set.
LaneBits testLanes(const float* offsets, const NodePlanes& planes);
/// The same in plain scalar code: what testLanes is held to, bit for bit.
LaneBits testLanesReference(const float* offsets, const NodePlanes& planes);

}  // namespace culld
