#include "culling/spatial/frustum_test.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "culling/core/sum_abs.h"
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
  const std::array<const glm::dvec4*, 2> across{&camera.x_row, &camera.y_row};
  for (std::size_t i = 0; i < across.size(); ++i) {
    const glm::dvec4& row = *across[i];
    const double parts = largest(camera.w_row) + largest(row);
    const PlaneMask low = add(camera.w_row + row, parts, reach);
    const PlaneMask high = add(camera.w_row - row, parts, reach);
    middles_[i] = {row, low, high};
  }
  const double parts = largest(camera.w_row) + largest(camera.z_row);
  const PlaneMask near = add(camera.near_cut_row, parts, reach);
  const PlaneMask far = add(camera.far_cut_row, parts, reach);
  middles_[2] = {camera.near_cut_row - camera.far_cut_row, near, far};
}

PlaneMask FrustumTest::add(const glm::dvec4& sum, double parts, double reach) {
  const double scale = largest(sum);
  // What is left of a far plane at infinity is rounding dust: no direction to trust. No plane culls
  // nothing, which is always right.
  constexpr double kDust = 0x1p-40;
  if (!(scale > kDust * parts)) return 0;
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
  return static_cast<PlaneMask>(1U << (count_ - 1));
}

/// Leaving a plane out is right whatever the octant; so nothing here needs a margin.
PlaneMask FrustumTest::inOctant(const WideNode& node, std::size_t lane, PlaneMask planes,
                                std::uint64_t& tests) const noexcept {
  for (const Middle& middle : middles_) {
    const PlaneMask both = middle.on_positive | middle.on_negative;
    if ((planes & both) != both) continue;  // its half is known already
    ++tests;
    double least = middle.row.w, most = middle.row.w;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<int>(axis);
      const double to_node = node.origin[axis] - eye_[a], n = middle.row[a];
      const double x = n * (to_node + static_cast<double>(node.offsets[kMinX + axis][lane]));
      const double y = n * (to_node + static_cast<double>(node.offsets[kMaxX + axis][lane]));
      least += std::min(x, y);
      most += std::max(x, y);
    }
    if (least >= 0.0) planes = static_cast<PlaneMask>(planes & ~middle.on_positive);
    if (most <= 0.0) planes = static_cast<PlaneMask>(planes & ~middle.on_negative);
  }
  return planes;
}

bool FrustumTest::outside(const OrientedBox& box, PlaneMask planes, bool sphere_first,
                          std::uint64_t& tests) const noexcept {
  const glm::dvec3 to_box = box.centre - eye_;
  const double reach = sumAbs(to_box) + box.reach;  // of all that is added up below
  const double turn = turn_ * reach * kUp;
  for (std::uint32_t p = 0; p < count_; ++p) {
    if ((planes >> p & 1U) == 0) continue;
    const Plane& plane = planes_[p];
    const double value = (plane.normal.x * to_box.x + plane.normal.y * to_box.y) +
                         (plane.normal.z * to_box.z + plane.distance) + shift_;
    const double margin = kDoubleSlack * (reach + sumAbs(box.centre) + sumAbs(eye_) +
                                          std::abs(plane.distance) + shift_) +
                          turn + kUnderflowSlack;
    if (sphere_first) {
      ++tests;
      if (value + box.radius + margin < 0.0) return true;
      if (value - box.radius - margin > 0.0) continue;
    }
    ++tests;
    double sides = 0.0;
    for (const glm::dvec3& half : box.half) sides += std::abs(glm::dot(plane.normal, half));
    if (value + sides + margin < 0.0) return true;
  }
  return false;
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
