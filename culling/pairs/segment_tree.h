// Boxes in a binary tree, to be asked which of them a segment meets. Split along the longest side,
// where surfaces are least.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "culling/core/box.h"

namespace culld {

class SegmentTree {
 public:
  static constexpr std::size_t kLeaf = 4;  ///< boxes of a leaf, at most

  SegmentTree() = default;
  /// REQUIRES: fewer than 2^31 boxes. COST: O(n log^2 n).
  explicit SegmentTree(std::span<const Box> boxes);

  /// Calls visit(index) for boxes that the segment may meet, until it returns true or `nodes`,
  /// which counts those that were looked at, comes to `most_nodes`. Rounding may lose boxes that
  /// are only touched.
  template <typename Visit>
  void any(const glm::dvec3& from, const glm::dvec3& to, std::uint64_t most_nodes,
           std::uint64_t& nodes, Visit visit) const;

  std::size_t bytes() const noexcept {
    return nodes_.capacity() * sizeof(Node) + order_.capacity() * sizeof(std::uint32_t);
  }

 private:
  struct Node {
    Box box;
    std::uint32_t first;  ///< of a leaf: in order_; else the first of two children
    std::uint32_t count;  ///< of a leaf's boxes; 0: no leaf
  };
  /// What the slab test needs of a segment.
  struct Segment {
    glm::dvec3 from, inverse;
  };
  static bool meets(const Segment& segment, const Box& box) noexcept;

  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
};

template <typename Visit>
void SegmentTree::any(const glm::dvec3& from, const glm::dvec3& to, std::uint64_t most_nodes,
                      std::uint64_t& nodes, Visit visit) const {
  if (nodes_.empty()) return;
  const Segment segment{from, 1.0 / (to - from)};
  std::uint32_t waiting[192];  // an eighth at least: no tree of 2^31 boxes is deeper
  std::size_t count = 0;
  waiting[count++] = 0;
  while (count > 0 && nodes < most_nodes) {
    const Node& node = nodes_[waiting[--count]];
    ++nodes;
    if (!meets(segment, node.box)) continue;
    for (std::uint32_t i = 0; i < node.count; ++i) {
      if (visit(order_[node.first + i])) return;
    }
    if (node.count != 0) continue;
    waiting[count++] = node.first;
    waiting[count++] = node.first + 1;
  }
}

}  // namespace culld
