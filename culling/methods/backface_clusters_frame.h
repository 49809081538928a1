// One frame of method `backface-clusters`: the nearest occluders are drawn without what of them
// turns away, then all boxes are held against that, and what is not hidden is asked whether all of
// it turns away.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "culling/culler.h"
#include "culling/occluders/facing_clusters.h"
#include "culling/occluders/image_walk.h"
#include "culling/occluders/occluder_drawing.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/depth_cells.h"
#include "culling/raster/sheet.h"
#include "culling/work_budget.h"

namespace culld {

/// The method's switches and numbers (docs/methods/backface-clusters.md). None changes the promise.
struct BackfaceClustersOptions {
  bool objects = true;    ///< those that turn away are left out
  bool occluders = true;  ///< the nearest objects are drawn, and hide
  bool clusters = true;   ///< those of occluders that turn away are not drawn
  bool hierarchy = true;  ///< clusters are asked from the top
  std::uint32_t most_triangles = 30'000;
  ClusterRules rules{};
};

/// Buffers kept from frame to frame for their memory only: nothing in them is read again.
struct BackfaceClustersMemory final : ViewState::Memory {
  std::vector<ImageItem> stack;
  std::vector<ImageItem> occluders;
  std::vector<SheetSurface> surfaces;
  SheetRasterizer sheets;
  DepthCells cells;
};

/// What the culler has prepared.
struct BackfaceClustersScene {
  const SceneSnapshot& scene;
  const WideBvh& bvh;
  std::span<const FacingClusters> clusters;  ///< by mesh
};

class BackfaceClustersFrame {
 public:
  /// Keeps references to all that it is given. REQUIRES: holdsInMotion(camera).
  BackfaceClustersFrame(const BackfaceClustersScene& scene, const BackfaceClustersOptions& options,
                        const Camera& camera, const Deadline& deadline, const Demand& demand,
                        BackfaceClustersMemory& memory);

  /// Appends the objects not left out to answer.visible, in no particular order.
  void run(Answer& answer);

 private:
  bool mayGoOn() { return budget_.mayGoOn(countedNs()); }
  std::uint64_t countedNs() const;  ///< work beside drawing
  void gatherOccluders();
  void drawOccluders();
  void draw(const ImageItem& item);
  bool hidden(const ImageItem& item);
  bool turnedAway(ObjectId id);

  const BackfaceClustersScene& scene_;
  const BackfaceClustersOptions& options_;
  const Deadline& deadline_;
  WorkBudget budget_;
  BackfaceClustersMemory& memory_;
  CellView view_;
  ImageWalk walk_;
  VolumeEye eye_;
  std::uint32_t triangles_left_;
  CullStats stats_;
  std::uint64_t regions_ = 0;  ///< of clusters, held against an eye
  std::uint32_t in_frustum_ = 0;
  std::uint64_t eyes_ = 0;  ///< moved into meshes
};

}  // namespace culld
