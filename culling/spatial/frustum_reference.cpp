#include <cmath>
#include <cstddef>

#include "culling/spatial/frustum_kernels.h"

namespace culld {
namespace {

constexpr std::size_t kLanes = 8;

/// Upper bound of hypot(a, b) for a, b >= 0 without squares, which would over- or underflow.
float aboveHypot(float a, float b) { return (a > b ? a : b) + (a < b ? a : b) * 0.41421359F; }

float turnMargin(const float* offsets, const NodePlanes& planes, std::size_t lane) {
  float far[3];
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float low = std::abs(planes.eye_to_node[axis] + offsets[axis * kLanes + lane]);
    const float high = std::abs(planes.eye_to_node[axis] + offsets[(axis + 3) * kLanes + lane]);
    far[axis] = low > high ? low : high;
  }
  return aboveHypot(aboveHypot(far[0], far[1]), far[2]) * planes.turn + planes.turn_slack;
}

struct Value {
  float sum, margin;
};

Value valueAt(const NodePlane& plane, float x, float y, float z) {
  const float tx = plane.normal[0] * x, ty = plane.normal[1] * y, tz = plane.normal[2] * z;
  const float size = (std::abs(plane.base) + std::abs(tx)) + (std::abs(ty) + std::abs(tz));
  return {(plane.base + tx) + (ty + tz), size * kFrustumMargin + plane.slack};
}

}  // namespace

LaneBits testLanesReference(const float* offsets, const NodePlanes& planes) {
  LaneBits bits;
  for (std::uint32_t p = 0; p < kMaxPlanes; ++p) bits.inside[p] = 0;
  for (std::size_t lane = 0; lane < kLanes; ++lane) {
    const float turn = planes.turn > 0.0F ? turnMargin(offsets, planes, lane) : 0.0F;
    for (std::uint32_t p = 0; p < planes.count; ++p) {
      const NodePlane& plane = planes.plane[p];
      float innermost[3], outermost[3];
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float low = offsets[axis * kLanes + lane];
        const float high = offsets[(axis + 3) * kLanes + lane];
        const bool rises = plane.normal[axis] >= 0.0F;
        innermost[axis] = rises ? high : low;
        outermost[axis] = rises ? low : high;
      }
      const Value in = valueAt(plane, innermost[0], innermost[1], innermost[2]);
      const Value out = valueAt(plane, outermost[0], outermost[1], outermost[2]);
      if (in.sum + (in.margin + turn) < 0.0F) bits.outside |= 1U << lane;
      if (out.sum - out.margin > 0.0F) bits.inside[p] |= 1U << lane;
    }
  }
  return bits;
}

}  // namespace culld
