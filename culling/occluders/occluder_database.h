// Which objects are worth considering as occluders at all, decided once per scene (Zhang 1998,
// occluder selection): none that are small, detailed, ill-shaped or redundant. What is left out
// here hides nothing, so these rules cost or save time and never change what an answer promises.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "culling/core/ids.h"
#include "culling/occluders/occluder_set.h"
#include "culling/scene/scene_snapshot.h"
#include "culling/spatial/wide_bvh.h"

namespace culld {

struct OccluderRules {
  /// Largest side of an object's box, as a share of the median over all that block.
  double least_size = 0.25;
  /// Polygons to draw: convex pieces, or triangles where there are none. 0: any number.
  std::uint32_t most_polygons = 2000;
  /// Area of what blocks, as a share of the surface of the mesh's box. Thin slanted things and
  /// loose foliage have big boxes that say little of where they are.
  double least_fill = 0.05;
  /// Leave out what lies on or in a larger object of one convex piece: the clock on the wall.
  bool leave_redundant = true;
};

/// Objects by what became of them, first rule first.
struct OccluderTally {
  std::size_t taken = 0, not_blocking = 0, small = 0, detailed = 0, ill_shaped = 0, redundant = 0;
};

class OccluderDatabase {
 public:
  /// REQUIRES: `bvh` and `set` of that scene. COST: O(triangles) once, then less than 10 us per
  /// object, whatever lies where.
  static OccluderDatabase of(const SceneSnapshot& scene, const WideBvh& bvh, const OccluderSet& set,
                             const OccluderRules& rules);
  /// For the next version of the scene: judges the objects in `changed` only, by the median of the
  /// first version.
  OccluderDatabase edited(const SceneSnapshot& next, const WideBvh& bvh, const OccluderSet& set,
                          std::span<const ObjectId> changed) const;

  bool holds(ObjectId id) const noexcept { return verdicts_[id] == Verdict::kTaken; }
  OccluderTally tally() const noexcept;
  std::size_t bytes() const noexcept;

 private:
  friend class OccluderJudge;
  enum class Verdict : std::uint8_t {
    kTaken,
    kNotBlocking,
    kSmall,
    kDetailed,
    kIllShaped,
    kRedundant
  };

  OccluderRules rules_;
  double least_side_m_ = 0.0;
  std::vector<Verdict> verdicts_;  ///< by object
};

}  // namespace culld
