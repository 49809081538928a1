// The closed parts of all objects of a scene, where they stand in the world: what may be proven
// solid (docs/error-model/solids.md §1).
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "culling/core/box.h"
#include "culling/core/ids.h"
#include "culling/occluders/closed_parts.h"
#include "culling/scene/scene_snapshot.h"
#include "culling/spatial/triangle_voxels.h"

namespace culld {

struct SolidPart {
  ObjectId object;
  const ClosedPart* part;  ///< of the object's mesh; owned by SolidParts
  Box box_world;           ///< of its vertices, rounded
  bool mirrored;           ///< world triangles run CW around their fronts
  double rounding_m;       ///< no coordinate of its triangles is off by more
};

class SolidParts {
 public:
  /// The largest kMostParts. Keeps a reference to `scene`. COST: O(triangles of meshes + objects).
  static SolidParts of(const SceneSnapshot& scene);

  static constexpr std::size_t kMostParts = 1U << 17U;
  static constexpr std::size_t kMostTrianglesOfPart = 1U << 18U, kMostPartsOfMesh = 1U << 12U;

  /// Largest first.
  std::span<const SolidPart> parts() const noexcept { return parts_; }
  /// Its triangles with vertices rounded to doubles: shared vertices stay shared.
  void appendTriangles(const SolidPart& part, std::vector<WorldTriangle>& out) const;

 private:
  explicit SolidParts(const SceneSnapshot& scene) : scene_(&scene) {}
  void addObject(ObjectId id);
  void keepLargest();

  const SceneSnapshot* scene_;
  std::vector<std::unique_ptr<const std::vector<ClosedPart>>> of_mesh_;
  std::vector<SolidPart> parts_;
};

}  // namespace culld
