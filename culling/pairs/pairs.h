// Which viewers may see which targets? Visibility for more than drawing: what a game server sends
// to whom, what a sensor can tell. Each pair is proven hidden by one convex occluder, or kept.
// Like corner culling (78, "CornerCulling", 2020), but with occluders found in the scene, and with
// proofs (docs/error-model/pairs.md).
#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "culling/core/clock.h"
#include "culling/core/result.h"
#include "culling/occluders/convex_pieces.h"
#include "culling/pairs/places.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

struct PairsAnswer {
  /// Bit v * targets + t, lowest bit of each byte first: 0 only if no segment from viewer v's place
  /// to target t's is free of blocking surfaces. The targets themselves block nothing.
  std::vector<std::uint8_t> may_see;
  bool out_of_budget = false;                   ///< stopped early: pairs not looked at are kept
  std::uint64_t hidden = 0;                     ///< pairs
  std::uint64_t nodes_visited = 0, tested = 0;  ///< nodes and occluders, over all pairs
  std::chrono::nanoseconds time{0};
};

/// By mesh what can hide: of one made of convex parts alone these parts, of another its largest
/// flat faces.
using MeshPieces = std::vector<ConvexPieces>;

/// No edit changes meshes: versions of a scene may share them. COST: O(triangles), on all cores.
std::shared_ptr<const MeshPieces> piecesOfMeshes(const SceneSnapshot& scene);

/// A snapshot's occluders, ready for questions about pairs. Immutable. THREADS: any.
class PairsCuller {
 public:
  /// About so many of a scene's occluders are kept, the largest by the surface of their boxes.
  static constexpr std::size_t kMostBlockers = std::size_t{1} << 14;

  /// COST: O(n log n) in the pieces of the scene's objects. REQUIRES: pieces of its meshes.
  PairsCuller(const SceneSnapshot& scene, std::shared_ptr<const MeshPieces> pieces);
  explicit PairsCuller(const SceneSnapshot& scene) : PairsCuller(scene, piecesOfMeshes(scene)) {}
  ~PairsCuller();

  /// `time`: 0 for no limit. ERROR: kInvalidInput: a place that is empty, not finite or farther out
  /// than kFarthestPlace, or a radius that is no number from 0 to that; names it.
  Result<PairsAnswer> cull(std::span<const Place> viewers, std::span<const Place> targets,
                           std::chrono::nanoseconds time = {},
                           const Clock& clock = steadyClock()) const;

  std::size_t blockers() const noexcept;
  std::size_t bytes() const noexcept;

 private:
  struct Blockers;
  std::shared_ptr<const MeshPieces> pieces_;
  std::unique_ptr<const Blockers> blockers_;
};

}  // namespace culld
