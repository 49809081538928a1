// One frame of method `horizon`: a sweep that meets nodes and objects at their nearest point and
// what hides at its farthest, so that all that is on the horizon lies before what is compared.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/culler.h"
#include "culling/occluders/occluder_drawing.h"
#include "culling/raster/box_kernels.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/horizon.h"
#include "culling/raster/sheet_skyline.h"
#include "culling/spatial/frustum_test.h"
#include "culling/spatial/wide_bvh.h"
#include "culling/work_budget.h"

namespace culld {

/// The published parts, to be left out one by one. None changes what an answer promises.
struct HorizonParts {
  bool sweep;      ///< occluders join at their farthest point; off: as soon as they are met
  bool tree;       ///< columns under a binary tree; off: looked at one by one
  bool hierarchy;  ///< nodes are compared with the horizon too; off: objects only
  std::uint32_t slice_columns;  ///< of an occluder, joining together; 0: all of it
  float least_gain;  ///< share of an object's rectangle beyond the horizon, or it stays out
};

/// A node or an object on its way through the sweep.
struct HorizonItem {
  ColumnRect rect;
  float nearest;
  ChildRef ref;
  PlaneMask planes;  ///< still to be tested below a node
  bool blocks;
};

/// A slice on its way to the horizon.
struct WaitingSlice {
  float nearest;  ///< its own nearness, which no point of what it hides with falls below
  std::uint32_t slice;
};

/// Buffers kept from frame to frame for their memory only: nothing in them is read again.
struct HorizonMemory final : ViewState::Memory {
  Horizon horizon;
  Horizon coming;  ///< as it will be once all that waits has joined: for choices only
  HorizonSlices slices;
  std::vector<WaitingSlice> waiting;  ///< a heap, nearest on top
  std::vector<HorizonItem> queue;     ///< a heap, nearest on top
  SheetSkyline skyline;
  std::vector<SheetSurface> surfaces;
};

class HorizonWalk {
 public:
  /// REQUIRES: a camera without a motion bound.
  HorizonWalk(const SceneSnapshot& scene, const WideBvh& bvh, const Camera& camera,
              const Deadline& deadline, const Demand& demand, const HorizonParts& parts,
              HorizonMemory& memory);

  /// Appends the objects not proven hidden to answer.visible, in no particular order.
  void run(Answer& answer);

 private:
  void takeNearest(Answer& answer);
  void sweepTo(float nearest);
  void visitNode(const HorizonItem& item);
  void takeHidden(const HorizonItem& item);
  void keepTheRest(Answer& answer);
  bool worthAdding(const HorizonItem& item, const Mesh& mesh) const;
  void addOccluder(const HorizonItem& item);
  void queueSlices(std::size_t first);
  void join(const HorizonSlice& slice);
  bool hidden(const HorizonItem& item);
  void push(const HorizonItem& item);
  HorizonItem pop();
  std::uint64_t countedNs() const;  ///< work beside drawing

  const SceneSnapshot& scene_;
  const WideBvh& bvh_;
  const Deadline& deadline_;
  WorkBudget budget_;
  const HorizonParts& parts_;
  HorizonMemory& memory_;
  FrustumTest frustum_;
  CellView view_;
  BoxView box_view_;
  glm::dvec3 origin_world_;
  CullStats stats_;
  std::uint32_t in_frustum_ = 0;  ///< objects found so far, those below hidden nodes too
};

}  // namespace culld
