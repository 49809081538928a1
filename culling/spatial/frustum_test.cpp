#include "culling/spatial/frustum_test.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "culling/spatial/wide_bvh_fit.h"

namespace culld {
namespace {

// Sixteen of the smallest normal floats: more than all underflow of one kernel value together.
constexpr double kUnderflowSlack = 0x1p-122;
// 32 double roundings, where the sums below make at most 12.
constexpr double kDoubleSlack = 0x1p-48;
// A factor that outweighs the few roundings of the line that uses it.
constexpr double kUp = 1.0 + 0x1p-40;
constexpr double kFloatUp = 1.0 + 0x1p-20;

float toFloat(double x) {
  constexpr double kMax = std::numeric_limits<float>::max();
  if (std::abs(x) <= kMax) return static_cast<float>(x);
  return std::numeric_limits<float>::infinity();  // an infinite term makes the kernel keep
}

float toFloatUp(double x) { return toFloat(x * kFloatUp + kUnderflowSlack); }

double sumAbs(const glm::dvec3& v) { return std::abs(v.x) + std::abs(v.y) + std::abs(v.z); }

double largest(const glm::dvec4& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

Box boundsOf(const WideBvh& bvh) {
  Box box;
  for (std::uint32_t root = 0; root < bvh.rootCount(); ++root) box.grow(boundsOf(bvh.node(root)));
  return box;
}

/// Largest offset that any node within `box` can hold.
double reachOf(const Box& box) { return box.empty() ? 0.0 : sumAbs(box.max - box.min) * kUp; }

}  // namespace

FrustumTest::FrustumTest(const Camera& camera, const WideBvh& bvh)
    : FrustumTest(camera, boundsOf(bvh)) {}

FrustumTest::FrustumTest(const Camera& camera, const Box& everything) : eye_(camera.origin_world) {
  const double reach = reachOf(everything);
  const MotionBound& motion = camera.motion;
  if (motion.angle_rad > 0.0) {
    turn_ = 2.0 * std::sin(std::min(motion.angle_rad, std::numbers::pi) / 2.0) * kUp;
  }
  shift_ = motion.radius_m * kUp;
  for (const glm::dvec4* row : {&camera.x_row, &camera.y_row}) {
    const double parts = largest(camera.w_row) + largest(*row);
    add(camera.w_row + *row, parts, reach);
    add(camera.w_row - *row, parts, reach);
  }
  for (const glm::dvec4* cut : {&camera.near_cut_row, &camera.far_cut_row}) {
    add(*cut, largest(camera.w_row) + largest(camera.z_row), reach);
  }
}

void FrustumTest::add(const glm::dvec4& sum, double parts, double reach) {
  const double scale = largest(sum);
  // What is left of a far plane at infinity is rounding dust: no direction to trust. No plane culls
  // nothing, which is always right.
  constexpr double kDust = 0x1p-40;
  if (!(scale > kDust * parts)) return;
  const glm::dvec4 scaled = sum / scale;
  const glm::dvec3 direction(scaled);
  const double length =
      std::sqrt(direction.x * direction.x + direction.y * direction.y + direction.z * direction.z);
  Plane& plane = planes_[count_++];
  plane.normal = direction / length;
  plane.distance = scaled.w / length;
  plane.tiny_slack = kUnderflowSlack;
  for (int axis = 0; axis < 3; ++axis) {
    const double n = plane.normal[axis];
    plane.normal_float[static_cast<std::size_t>(axis)] = static_cast<float>(n);
    const bool subnormal = n != 0.0 && std::abs(n) < 0x1p-126;
    if (subnormal) plane.tiny_slack += 0x1p-148 * reach;
  }
}

NodePlanes FrustumTest::forNode(const WideNode& node, PlaneMask mask) const noexcept {
  NodePlanes out;
  const glm::dvec3 to_node(node.origin[0] - eye_.x, node.origin[1] - eye_.y,
                           node.origin[2] - eye_.z);
  const double far_slack = 0x1p-1000 * sumAbs(to_node);
  for (std::uint32_t p = 0; p < count_; ++p) {
    if ((mask >> p & 1U) == 0) continue;
    const Plane& plane = planes_[p];
    const glm::dvec3 terms = plane.normal * to_node;
    const double size = sumAbs(terms) + std::abs(plane.distance) + shift_;
    NodePlane& to = out.plane[out.count++];
    for (std::size_t axis = 0; axis < 3; ++axis) to.normal[axis] = plane.normal_float[axis];
    to.base = toFloat(((terms.x + terms.y) + (terms.z + plane.distance)) + shift_);
    to.slack = toFloatUp(size * kDoubleSlack + plane.tiny_slack + far_slack);
  }
  if (turn_ > 0.0) {
    for (int axis = 0; axis < 3; ++axis) out.eye_to_node[axis] = toFloat(to_node[axis]);
    out.turn = toFloatUp(turn_ * (1.0 + 0x1p-19));
    out.turn_slack = toFloatUp(turn_ * 0x1p-22 * sumAbs(to_node));
  }
  return out;
}

LaneVerdicts FrustumTest::test(const WideNode& node, PlaneMask mask) const noexcept {
  LaneVerdicts verdicts;
  verdicts.tested = mask;
  const LaneBits bits = testLanes(&node.offsets[0][0], forNode(node, mask));
  verdicts.may_intersect = node.live & ~bits.outside;
  for (std::uint32_t p = 0, i = 0; p < count_; ++p) {
    if ((mask >> p & 1U) != 0) verdicts.inside[p] = bits.inside[i++];
  }
  return verdicts;
}

}  // namespace culld
