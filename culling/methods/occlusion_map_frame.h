// One frame of method `occlusion-map`: occluders chosen by their size on the image, drawn, made
// into a pyramid and a depth estimation; then all boxes against both.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/culler.h"
#include "culling/occluders/image_walk.h"
#include "culling/occluders/occluder_database.h"
#include "culling/occluders/occluder_drawing.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/depth_cells.h"
#include "culling/raster/depth_estimation.h"
#include "culling/raster/hole_ledger.h"
#include "culling/raster/occlusion_map.h"
#include "culling/spatial/wide_bvh.h"
#include "culling/work_budget.h"

namespace culld {

/// The method's switches and numbers (docs/methods/occlusion-map.md).
struct OcclusionMapOptions {
  OccluderRules database{};
  std::uint32_t most_occluders = 1024;
  std::uint32_t most_polygons = 40'000;
  std::uint32_t levels = 6;
  double opacity = 0.9375;  ///< used only where holes are accepted
  double give_up = 1.0;
  std::uint32_t depth_regions = 128;
  bool depth_of_cells = true;  ///< no-background Z-buffer; else boxes, the depth estimation buffer
  double accepted_px = 0.0;    ///< accepted loss where the demand names none
};

/// Buffers kept from frame to frame for their memory only: nothing in them is read again.
struct OcclusionMapMemory final : ViewState::Memory {
  DepthCells cells;
  OccluderScratch occluder;
  OcclusionMap map;
  DepthEstimation depth;
  HoleLedger ledger;
  std::vector<ImageItem> queue;   ///< a heap, largest on the image on top
  std::vector<ImageItem> chosen;  ///< occluders
  std::vector<ImageItem> stack;
};

/// What the culler has prepared.
struct OcclusionMapScene {
  const SceneSnapshot& scene;
  const WideBvh& bvh;
  const OccluderSet& occluders;
  const OccluderDatabase& database;
  const std::vector<std::uint8_t>& see_through;  ///< by mesh: not all of it blocks
  bool all_block;                                ///< no mesh of the scene is see-through
};

class OcclusionMapFrame {
 public:
  OcclusionMapFrame(const OcclusionMapScene& scene, const OcclusionMapOptions& options,
                    const Camera& camera, const Deadline& deadline, const Demand& demand,
                    OcclusionMapMemory& memory);

  /// Appends the objects not left out to answer.visible, in no particular order.
  void run(Answer& answer);

 private:
  void chooseOccluders();
  bool choose(const ImageItem& item);
  void drawOccluders();
  float farthestOf(const Instance& instance) const;
  bool hidden(const ImageItem& item);
  std::uint32_t holeFor(const ImageItem& item) const;
  bool mayGoOn() { return budget_.mayGoOn(countedNs()); }
  std::uint64_t countedNs() const;  ///< work beside drawing

  const OcclusionMapScene& scene_;
  const OcclusionMapOptions& options_;
  WorkBudget budget_;
  OcclusionMapMemory& memory_;
  CellView view_;
  glm::dvec3 origin_world_;
  ImageWalk walk_;
  OccluderDrawing drawing_;
  double image_px_;
  double accepted_px_;      ///< that may be lost; 0: nothing
  std::uint32_t hole_ = 0;  ///< cells of a texel that may stay open
  std::uint32_t polygons_left_;
  CullStats stats_;
  std::uint32_t in_frustum_ = 0;
  std::uint64_t texels_ = 0;  ///< looked at
};

}  // namespace culld
