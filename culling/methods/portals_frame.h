// One frame of method `portals`: the solid boxes that are largest on the image, drawn front to
// back; then all of the scene's boxes against what they cover.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/culler.h"
#include "culling/occluders/image_walk.h"
#include "culling/occluders/occluder_drawing.h"
#include "culling/occluders/solid_occluders.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/depth_cells.h"
#include "culling/spatial/wide_bvh.h"
#include "culling/work_budget.h"

namespace culld {

/// Buffers kept from frame to frame for their memory only: nothing in them is read again.
struct PortalsMemory final : ViewState::Memory {
  DepthCells cells;
  OccluderScratch occluder;
  std::vector<ImageItem> queue;   ///< a heap, largest on the image on top
  std::vector<ImageItem> chosen;  ///< solid boxes
  std::vector<ImageItem> stack;
};

class PortalsFrame {
 public:
  PortalsFrame(const WideBvh& bvh, const SolidOccluders& solids, std::uint32_t most_boxes,
               const Camera& camera, const Deadline& deadline, const Demand& demand,
               PortalsMemory& memory);

  /// Appends the objects not proven hidden to answer.visible, in no particular order.
  void run(Answer& answer);

 private:
  void chooseBoxes();
  void drawBoxes();
  bool mayGoOn() { return budget_.mayGoOn(countedNs()); }
  std::uint64_t countedNs() const;  ///< work beside drawing

  const SolidOccluders& solids_;
  std::uint32_t most_boxes_;
  WorkBudget budget_;
  PortalsMemory& memory_;
  CellView view_;
  ImageWalk walk_;
  ImageWalk solid_walk_;
  OccluderDrawing drawing_;
  CullStats stats_;
  std::uint32_t in_frustum_ = 0;
};

}  // namespace culld
