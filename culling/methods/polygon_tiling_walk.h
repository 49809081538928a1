// One frame of method `polygon-tiling`: the octree of BSP trees strictly front to back, so that
// what covers a cell is before all that is met later, and no depth has to be kept.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "culling/culler.h"
#include "culling/methods/polygon_tiling_scene.h"
#include "culling/occluders/occluder_drawing.h"
#include "culling/occluders/occluder_set.h"
#include "culling/raster/box_kernels.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/coverage_pyramid.h"
#include "culling/raster/depth_cells.h"
#include "culling/spatial/frustum_test.h"
#include "culling/work_budget.h"

namespace culld {

/// From where the scene is seen: which side of a plane comes first.
struct ViewSide {
  bool known = false;  ///< false: no strict order holds for this camera
  bool perspective = true;
  glm::dvec3 eye{0.0}, toward_eye{0.0};  ///< the second if the rays are parallel
  /// Is the side of larger coordinates nearer?
  bool highFirst(int axis, double plane) const noexcept {
    return perspective ? eye[axis] >= plane : toward_eye[axis] > 0.0;
  }
};

/// Not known for a camera in motion, nor for parallel rays that may be parallel to an axis' planes
/// up to rounding, but are not exactly.
ViewSide viewSide(const Camera& camera) noexcept;

/// Buffers kept from frame to frame for their memory only: nothing in them is read again.
struct PolygonTilingMemory final : ViewState::Memory {
  DepthCells cells;  ///< of one occluder at a time
  CoveragePyramid coverage;
  OccluderScratch occluder;
  std::vector<CellRect> except;
  std::unordered_map<ObjectId, std::uint32_t> tilings;  ///< by occluder, in this frame
  std::vector<std::uint32_t> kept_in;                   ///< by object: the frame in which it was
  std::uint32_t frame = 0;
};

class PolygonTilingWalk {
 public:
  PolygonTilingWalk(const PolygonTilingScene& scene, const OccluderSet& occluders,
                    std::uint32_t levels, const Camera& camera, const Deadline& deadline,
                    const Demand& demand, PolygonTilingMemory& memory);

  /// Appends the objects not proven hidden to answer.visible, each once, in no particular order.
  void run(Answer& answer);
  bool occlusion() const noexcept { return side_.known; }

 private:
  using Ids = std::vector<ObjectId>;  ///< occluders met, of which parts are still to come

  bool mayGoOn() { return budget_.mayGoOn(countedNs()); }
  void beginFrame();
  void takeNode(std::uint32_t node, const Box& region, PlaneMask planes, Ids& met);
  void takeTree(const BspTree& tree, std::uint32_t index, const Box& region, PlaneMask planes,
                bool tile, Ids& met);
  void takeGroup(const BspTree& tree, const BspNode& group, PlaneMask planes, Ids& met);
  void tileAfterOctant(const Box& region, const glm::dvec3& centre, std::uint32_t octant,
                       std::uint32_t passed, Ids& met);
  void tileAfterRegion(const Box& region, const BspNode& cut, Ids& met);
  void tile(ObjectId id, std::span<const Box> to_come);
  Box withTies(Box box) const;
  bool cellsOf(const Box& box, CellRect& rect, float& nearest) const;
  bool covered(const CellRect& rect, float nearest);
  void keep(ObjectId id);
  std::uint64_t countedNs() const;  ///< work beside drawing

  const PolygonTilingScene& scene_;
  const OccluderSet& occluders_;
  std::uint32_t levels_;
  WorkBudget budget_;
  PolygonTilingMemory& memory_;
  ViewSide side_;
  FrustumTest frustum_;
  CellView view_;
  BoxView box_view_;
  glm::dvec3 eye_world_;
  OccluderDrawing drawing_;
  Answer* answer_ = nullptr;
  CullStats stats_;
};

}  // namespace culld
