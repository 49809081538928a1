// One frame of method `layers`. Conservative: the first cells are drawn as occluders, then all
// boxes are held against them. Approximate: the first cells are the answer.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/culler.h"
#include "culling/methods/layers_order.h"
#include "culling/occluders/image_walk.h"
#include "culling/occluders/occluder_drawing.h"
#include "culling/occluders/solid_grid.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/depth_cells.h"
#include "culling/spatial/wide_bvh.h"
#include "culling/work_budget.h"

namespace culld {

/// The method's switches and numbers (docs/methods/layers.md).
struct LayersOptions {
  double cells_per_object = 2.0;
  double solidity = 0.4;
  std::uint32_t most_polygons = 40'000;  ///< drawn, conservative
  std::uint32_t most_triangles = 0;      ///< answered, approximate; 0: no limit
  double accepted_px = 0.0;              ///< accepted loss where the demand names none
};

/// Buffers kept from frame to frame for their memory only: nothing in them is read again.
struct LayersMemory final : ViewState::Memory {
  LayersOrderMemory order;
  DepthCells cells;
  OccluderScratch occluder;
  std::vector<std::uint8_t> projected;  ///< by object
  std::vector<ObjectId> fresh;
  std::vector<ImageItem> stack;
};

/// What the culler has prepared.
struct LayersScene {
  const SceneSnapshot& scene;
  const WideBvh& bvh;
  const OccluderSet& occluders;
  const SolidGrid& grid;
};

class LayersFrame {
 public:
  LayersFrame(const LayersScene& scene, const LayersOptions& options, const Camera& camera,
              const Deadline& deadline, const Demand& demand, LayersMemory& memory);

  /// Appends the objects not left out to answer.visible, in no particular order.
  void run(Answer& answer);

 private:
  void freshObjects(std::span<const ObjectId> ids);
  void projectAll(Answer& answer);
  void project(std::span<const ObjectId> ids, Answer& answer);
  void drawAll();
  void draw(std::span<const ObjectId> ids);
  void drawObject(const ImageItem& item);
  bool hidden(const ImageItem& item) {
    return memory_.cells.certainlyHidden(item.rect, item.nearest);
  }
  bool mayGoOn() { return budget_.mayGoOn(countedNs()); }
  std::uint64_t countedNs() const;  ///< work beside drawing

  const LayersScene& scene_;
  const LayersOptions& options_;
  const Camera& camera_;
  WorkBudget budget_;
  LayersMemory& memory_;
  CellView view_;
  ImageWalk walk_;
  OccluderDrawing drawing_;
  double accepted_px_;            ///< that may be lost; 0: nothing
  std::uint64_t most_triangles_;  ///< answered; 0: no limit
  std::uint32_t polygons_left_;
  std::uint64_t triangles_answered_ = 0;
  CullStats stats_;
  std::uint32_t in_frustum_ = 0;
  std::uint64_t cells_projected_ = 0;
};

}  // namespace culld
