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
  std::uint32_t tested = 0;       ///< objects tested one by one
  std::uint64_t plane_tests = 0;  ///< comparisons of a box or a sphere with a plane
  bool out_of_time = false;       ///< what was undecided then is among the objects
  /// Of a frame that answers what the walk has found: counted work, priced (docs/planner.md).
  std::chrono::nanoseconds work(std::size_t answered) const noexcept;
};

/// What a walk remembers for the next one of the same tree, or of one made from it by edits: by
/// node, the plane that left out most of it. Any content is right: it changes the work only.
struct FrustumCoherence {
  static constexpr std::uint8_t kNone = kMaxPlanes;
  std::vector<std::uint8_t> best_plane;
};

/// The published parts; as a rule plane masking alone (docs/methods/frustum.md).
struct FrustumParts {
  bool masking = true;                      ///< planes that a node is inside of end there
  bool octants = false;                     ///< three planes for what lies in one octant
  FrustumCoherence* coherence = nullptr;    ///< planes one by one, the last walk's best one first
  const SceneSnapshot* oriented = nullptr;  ///< objects that are turned by their mesh's box too
  bool sphere = true;                       ///< and before that by the sphere around it
};

/// Appends the objects that the frustum may hold, each once, in no particular order.
/// `bvh.alwaysKept()` is not among them.
FrustumWalkStats appendInFrustum(const WideBvh& bvh, const FrustumTest& frustum,
                                 const Deadline& deadline, std::vector<ObjectId>& out,
                                 const FrustumParts& parts = {});

/// How many objects at and below a node appendInFrustum would find. `planes`: those still to be
/// tested there.
std::uint32_t countInFrustum(const WideBvh& bvh, const FrustumTest& frustum, std::uint32_t index,
                             PlaneMask planes);

/// Sorts distinct ids below `limit`. COST: O(n) where they are dense, O(n log n) where they are
/// few.
void sortIds(std::vector<ObjectId>& ids, std::size_t limit);

}  // namespace culld
