// Walks a BVH down to the objects that a camera's frustum may hold: the first step of every method
// that culls with boxes. Hierarchical with plane masking (Assarsson, Moller 2000).
#pragma once
#include <chrono>
#include <cstdint>
#include <vector>

#include "culling/core/clock.h"
#include "culling/spatial/frustum_test.h"
#include "culling/spatial/wide_bvh.h"

namespace culld {

/// A moment after which work is cut short. Zero time: never.
class Deadline {
 public:
  Deadline(const Clock& clock, std::chrono::nanoseconds start, std::chrono::nanoseconds time)
      : clock_(clock), end_(start + time), limited_(time.count() > 0) {}
  bool passed() const noexcept { return limited_ && clock_.now() >= end_; }

 private:
  const Clock& clock_;
  std::chrono::nanoseconds end_;
  bool limited_;
};

struct FrustumWalkStats {
  std::uint32_t nodes_visited = 0;
  std::uint32_t tested = 0;  ///< objects tested one by one
  bool out_of_time = false;  ///< what was undecided then is among the objects
};

/// Appends the objects that the frustum may hold, each once, in no particular order.
/// `bvh.alwaysKept()` is not among them.
FrustumWalkStats appendInFrustum(const WideBvh& bvh, const FrustumTest& frustum,
                                 const Deadline& deadline, std::vector<ObjectId>& out);

/// Sorts distinct ids below `limit`. COST: O(n) where they are dense, O(n log n) where they are
/// few.
void sortIds(std::vector<ObjectId>& ids, std::size_t limit);

}  // namespace culld
