// A BSP tree over a few boxes, with axis-parallel planes along their sides (Fuchs, Kedem, Naylor
// 1980): what lies on the eye's side of a plane comes before all that lies beyond it, strictly.
// Boxes that no plane separates stay together in a group. A box that a plane cuts has a part on
// either side. For the leaves of an octree of BSP trees (Greene 1996).
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "culling/core/box.h"
#include "culling/core/ids.h"
#include "culling/spatial/wide_bvh.h"

namespace culld {

struct BspPart {
  ObjectId id;
  Box box;
  bool blocking;
};

struct BspNode {
  static constexpr std::uint8_t kGroup = 3;
  std::uint8_t axis = kGroup;
  double plane = 0.0;
  /// What is < plane, then what is not; for a group the first of its lanes, and their end.
  std::uint32_t below[2] = {0, 0};
};

class BspTree {
 public:
  /// `split`: false makes one group of all. COST: O(n^2) per level, for a few dozen parts.
  static BspTree of(std::span<const BspPart> parts, bool split);

  bool empty() const noexcept { return nodes_.empty(); }
  const BspNode& node(std::uint32_t index) const noexcept { return nodes_[index]; }  ///< 0: root
  /// Boxes of parts, as WideBvh's nodes hold those of objects.
  const WideNode& lanes(std::uint32_t index) const noexcept { return lanes_[index]; }
  std::size_t bytes() const noexcept;

 private:
  friend class BspBuilder;
  std::vector<BspNode> nodes_;
  std::vector<WideNode> lanes_;
};

}  // namespace culld
