#include "culling/spatial/bsp_tree.h"

#include <algorithm>

#include "culling/spatial/wide_bvh_fit.h"

namespace culld {
namespace {

constexpr std::size_t kFewest = 2;       ///< parts worth a plane
constexpr std::size_t kMostTried = 128;  ///< more parts in one place are not told apart

struct Plane {
  std::uint8_t axis = BspNode::kGroup;
  double at = 0.0;
  std::size_t cost = 0;
};

bool reachesLow(const Box& box, int axis, double plane) { return box.min[axis] < plane; }
bool reachesHigh(const Box& box, int axis, double plane) { return !(box.max[axis] < plane); }

}  // namespace

class BspBuilder {
 public:
  BspBuilder(BspTree& out, std::size_t most_parts) : out_(out), left_(most_parts) {}

  std::uint32_t add(const std::vector<BspPart>& parts, bool split) {
    const auto index = static_cast<std::uint32_t>(out_.nodes_.size());
    out_.nodes_.push_back({});
    const Plane plane = split ? best(parts) : Plane{};
    BspNode node;
    node.axis = plane.axis;
    node.plane = plane.at;
    if (plane.axis == BspNode::kGroup) {
      addGroup(parts, node);
    } else {
      const int axis = plane.axis;
      std::vector<BspPart> low, high;
      for (const BspPart& part : parts) {
        const bool to_low = reachesLow(part.box, axis, plane.at);
        const bool to_high = reachesHigh(part.box, axis, plane.at);
        if (to_low) low.push_back(part);
        if (to_high) high.push_back(part);
        if (!to_low || !to_high) continue;
        low.back().box.max[axis] = plane.at;
        high.back().box.min[axis] = plane.at;
        --left_;
      }
      node.below[0] = add(low, true);
      node.below[1] = add(high, true);
    }
    out_.nodes_[index] = node;
    return index;
  }

 private:
  /// The plane along a side of a box that cuts fewest, then divides most evenly. None if every
  /// plane leaves all parts on one side.
  Plane best(const std::vector<BspPart>& parts) const {
    Plane best;
    if (parts.size() < kFewest || parts.size() > kMostTried) return best;
    for (std::uint8_t axis = 0; axis < 3; ++axis) {
      for (const BspPart& part : parts) {
        for (const double at : {part.box.min[axis], part.box.max[axis]})
          consider(parts, axis, at, best);
      }
    }
    return best;
  }

  void consider(const std::vector<BspPart>& parts, std::uint8_t axis, double at,
                Plane& best) const {
    std::size_t low = 0, high = 0;
    for (const BspPart& part : parts) {
      if (reachesLow(part.box, axis, at)) ++low;
      if (reachesHigh(part.box, axis, at)) ++high;
    }
    const std::size_t cut = low + high - parts.size();
    if (low == parts.size() || high == parts.size() || cut > left_) return;
    const std::size_t cost = parts.size() * cut + std::max(low, high);
    if (best.axis == BspNode::kGroup || cost < best.cost) best = {axis, at, cost};
  }

  void addGroup(const std::vector<BspPart>& parts, BspNode& node) {
    node.below[0] = static_cast<std::uint32_t>(out_.lanes_.size());
    for (std::size_t begin = 0; begin < parts.size(); begin += kWideLanes) {
      WideNode lanes = emptyNode();
      Box boxes[kWideLanes];
      std::uint32_t blocking = 0;
      for (std::size_t l = 0; l < kWideLanes && begin + l < parts.size(); ++l) {
        const BspPart& part = parts[begin + l];
        lanes.child[l] = ChildRef::object(part.id);
        boxes[l] = part.box;
        blocking |= (part.blocking ? 1U : 0U) << l;
      }
      fitNode(lanes, boxes);
      lanes.blocking = static_cast<std::uint16_t>(blocking);
      out_.lanes_.push_back(lanes);
    }
    node.below[1] = static_cast<std::uint32_t>(out_.lanes_.size());
  }

  BspTree& out_;
  std::size_t left_;  ///< cuts that may still be made
};

BspTree BspTree::of(std::span<const BspPart> parts, bool split) {
  BspTree tree;
  if (parts.empty()) return tree;
  BspBuilder(tree, parts.size() / 2).add({parts.begin(), parts.end()}, split);
  tree.nodes_.shrink_to_fit();
  tree.lanes_.shrink_to_fit();
  return tree;
}

std::size_t BspTree::bytes() const noexcept {
  return nodes_.capacity() * sizeof(BspNode) + lanes_.capacity() * sizeof(WideNode);
}

}  // namespace culld
