// Walks a BVH down to the objects that a camera's frustum may hold: the first step of every method
// that culls with boxes. Hierarchical with plane masking (Assarsson, Moller 2000).
#pragma once
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "culling/core/clock.h"
#include "culling/spatial/frustum_test.h"
#include "culling/spatial/wide_bvh.h"

namespace culld {

struct FrustumWalkStats {
  std::uint32_t nodes_visited = 0;
  std::uint32_t tested = 0;  ///< objects tested one by one
  bool out_of_time = false;  ///< what was undecided then is among the objects
  /// Of a frame that answers what the walk has found: counted work, priced (docs/planner.md).
  std::chrono::nanoseconds work(std::size_t answered) const noexcept;
};

/// Appends the objects that the frustum may hold, each once, in no particular order.
/// `bvh.alwaysKept()` is not among them.
FrustumWalkStats appendInFrustum(const WideBvh& bvh, const FrustumTest& frustum,
                                 const Deadline& deadline, std::vector<ObjectId>& out);

/// How many objects at and below a node appendInFrustum would find. `planes`: those still to be
/// tested there.
std::uint32_t countInFrustum(const WideBvh& bvh, const FrustumTest& frustum, std::uint32_t index,
                             PlaneMask planes);

/// Sorts distinct ids below `limit`. COST: O(n) where they are dense, O(n log n) where they are
/// few.
void sortIds(std::vector<ObjectId>& ids, std::size_t limit);

}  // namespace culld
