// One frame of method `raster`: nearest first through the BVH, hidden nodes ended early, objects
// that are worth it drawn as occluders, and everything not hidden tested once more at the end.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/culler.h"
#include "culling/occluders/occluder_drawing.h"
#include "culling/occluders/occluder_set.h"
#include "culling/raster/box_kernels.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/depth_cells.h"
#include "culling/raster/moving_view.h"
#include "culling/raster/own_triangles.h"
#include "culling/spatial/frustum_test.h"
#include "culling/spatial/frustum_walk.h"
#include "culling/spatial/wide_bvh.h"

namespace culld {

/// A node or an object on its way through the walk.
struct RasterItem {
  CellRect rect;
  float nearest;
  ChildRef ref;
  PlaneMask planes;  ///< still to be tested below a node
};

/// Buffers kept from frame to frame for their memory only: nothing in them is read again.
struct RasterMemory final : ViewState::Memory {
  DepthCells cells;
  OccluderScratch occluder;
  std::vector<RasterItem> queue;       ///< a heap, nearest on top
  std::vector<RasterItem> candidates;  ///< objects not hidden by what was drawn before them
};

class RasterWalk {
 public:
  RasterWalk(const SceneSnapshot& scene, const WideBvh& bvh, const OccluderSet& occluders,
             const Camera& camera, const Deadline& deadline, const Demand& demand,
             RasterMemory& memory);

  /// Appends the objects not proven hidden to answer.visible, in no particular order.
  void run(Answer& answer);

 private:
  void visitNode(const RasterItem& item);
  bool takeNearest();
  void takeObject(const RasterItem& item, bool blocking);
  void answerCandidates(Answer& answer);
  bool askingPays(std::uint64_t stake_ns);
  bool hiddenByItsTriangles(const RasterItem& item, bool& out_of_budget);
  void takeHidden(const RasterItem& item);
  bool drawObject(const RasterItem& item);
  std::uint64_t workLeftNs() const;
  bool workLeft() const { return most_work_.count() == 0 || work() < most_work_; }
  void keepTheRest(Answer& answer);
  std::chrono::nanoseconds work() const;
  void push(const RasterItem& item);
  RasterItem pop();
  bool hidden(const RasterItem& item) const {
    return memory_.cells.certainlyHidden(item.rect, item.nearest);
  }

  const SceneSnapshot& scene_;
  const WideBvh& bvh_;
  const OccluderSet& occluders_;
  const Deadline& deadline_;
  std::chrono::nanoseconds most_work_;  ///< 0: no limit
  RasterMemory& memory_;
  FrustumTest frustum_;
  CellView view_;
  CellView asked_view_;  ///< the same, for what is asked instead of drawn
  BoxView box_view_;
  glm::dvec3 origin_world_;
  OccluderDrawing drawing_;
  bool ask_triangles_;  ///< demanded, and the view stands still
  CullStats stats_;
  std::uint32_t in_frustum_ = 0;  ///< objects found so far, those below hidden nodes too
  std::uint64_t drawing_ns_ = 0;  ///< counted work of all that was drawn, priced
  std::uint64_t asking_ns_ = 0;   ///< and of the objects asked by their own triangles
  std::uint64_t saved_ns_ = 0;    ///< what sending those would have cost that were left out so
  std::uint32_t unasked_ = 0;
};

}  // namespace culld
