#include "culling/pairs/segment_tree.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace culld {
namespace {

using Order = std::vector<std::uint32_t>;

int longestAxis(const Box& box) {
  const glm::dvec3 size = box.max - box.min;
  if (size.x >= size.y && size.x >= size.z) return 0;
  return size.y >= size.z ? 1 : 2;
}

/// How many of the boxes go to the first child: where the boxes' surface times their number is
/// least (MacDonald, Booth 1990). None of both gets less than an eighth, so that trees stay low.
std::uint32_t bestSplit(std::span<const std::uint32_t> order, std::span<const Box> boxes) {
  const std::size_t count = order.size();
  std::vector<double> after(count);  // surface of the boxes from i on
  Box box;
  for (std::size_t i = count; i-- > 0;) {
    box.grow(boxes[order[i]]);
    after[i] = halfArea(box);
  }
  box = {};
  std::size_t best = count / 2;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 1; i < count; ++i) {
    box.grow(boxes[order[i - 1]]);
    const double cost =
        halfArea(box) * static_cast<double>(i) + after[i] * static_cast<double>(count - i);
    if (8 * i < count || 8 * (count - i) < count || !(cost < least)) continue;
    least = cost;
    best = i;
  }
  return static_cast<std::uint32_t>(best);
}

}  // namespace

SegmentTree::SegmentTree(std::span<const Box> boxes) : order_(boxes.size()) {
  std::iota(order_.begin(), order_.end(), 0U);
  if (boxes.empty()) return;
  nodes_.push_back({{}, 0, static_cast<std::uint32_t>(boxes.size())});
  // Each node comes here as a leaf of all its boxes; children are appended, and so come later.
  for (std::size_t at = 0; at < nodes_.size(); ++at) {
    Node node = nodes_[at];
    const auto begin = order_.begin() + node.first, end = begin + node.count;
    Box centres;
    for (auto i = begin; i != end; ++i) {
      node.box.grow(boxes[*i]);
      centres.grow(0.5 * boxes[*i].min + 0.5 * boxes[*i].max);
    }
    if (node.count > kLeaf) {
      const int axis = longestAxis(centres);
      std::sort(begin, end, [&](std::uint32_t a, std::uint32_t b) {
        const double x = boxes[a].min[axis] + boxes[a].max[axis];
        const double y = boxes[b].min[axis] + boxes[b].max[axis];
        return x < y || (x == y && a < b);
      });
      const std::uint32_t half = bestSplit({begin, end}, boxes);
      const auto child = static_cast<std::uint32_t>(nodes_.size());
      nodes_.push_back({{}, node.first, half});
      nodes_.push_back({{}, node.first + half, node.count - half});
      node.first = child;
      node.count = 0;
    }
    nodes_[at] = node;
  }
  nodes_.shrink_to_fit();
}

/// Along a side the segment divides by zero, and the infinities say right; on the side's very plane
/// they do not, and a box that is only touched is lost.
bool SegmentTree::meets(const Segment& segment, const Box& box) noexcept {
  double enter = 0.0, leave = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double a = (box.min[axis] - segment.from[axis]) * segment.inverse[axis];
    const double b = (box.max[axis] - segment.from[axis]) * segment.inverse[axis];
    const double first = a < b ? a : b, last = a < b ? b : a;
    if (first > enter) enter = first;
    if (last < leave) leave = last;
  }
  return enter <= leave;
}

}  // namespace culld
