// One frame of method `z-pyramid`: the octree front to back, hidden nodes ended early, the objects
// of the others drawn; in the end, what was visited is held against the finished pyramid once more.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/culler.h"
#include "culling/occluders/occluder_drawing.h"
#include "culling/occluders/occluder_set.h"
#include "culling/raster/box_kernels.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/depth_cells.h"
#include "culling/raster/depth_pyramid.h"
#include "culling/spatial/frustum_test.h"
#include "culling/spatial/octree.h"
#include "culling/work_budget.h"

namespace culld {

/// The parts of the method that can be left out (docs/methods/z-pyramid.md).
struct ZPyramidParts {
  OctreeRules octree;
  std::uint32_t levels = DepthPyramid::kAllLevels;
  bool incremental = true;
  bool faces = true;
  bool coherence = true;
};

/// A node or an object's part in one octant, and what is asked after.
struct ZPyramidBox {
  CellRect rect{};
  float nearest = 0.0F;
  std::uint32_t lanes = OctreeNode::kNone;  ///< where its box is
  std::uint8_t lane = 0;
  OpenCell open;  ///< did not hide it when last asked
};

struct ZPyramidVisit {
  static constexpr std::uint32_t kNoParent = 0xFFFFFFFFU;
  ZPyramidBox box;
  std::uint32_t node = 0, parent = kNoParent;  ///< parent: index of the visit above
  PlaneMask planes = 0;
  bool hidden = false;
};

struct ZPyramidPart {
  ZPyramidBox box;
  ObjectId id = 0;
  std::uint32_t visit = 0;
};

/// Of one view. What is read again in the next frame are marks that say where to draw first; they
/// may be of another scene and do no harm.
struct ZPyramidMemory final : ViewState::Memory {
  ZPyramidMemory() { occluder.sheets.drawWhole(true); }
  bool sceneEdited() override { return true; }

  DepthCells cells;
  DepthPyramid pyramid;
  OccluderScratch occluder;
  std::vector<ZPyramidVisit> pending, visits;
  std::vector<ZPyramidPart> parts;
  std::vector<std::uint32_t> taken_in, kept_in;  ///< by object: the frame in which it was
  std::vector<std::uint32_t> visible_in;         ///< by node: the last frame that found it visible
  std::uint32_t frame = 0;
  std::uint32_t visible_frame = 0;  ///< the last one that was finished
};

class ZPyramidWalk {
 public:
  ZPyramidWalk(const SceneSnapshot& scene, const Octree& octree, const OccluderSet& occluders,
               const ZPyramidParts& parts, const Camera& camera, const Deadline& deadline,
               const Demand& demand, ZPyramidMemory& memory);

  /// Appends the objects not proven hidden to answer.visible, each once, in no particular order.
  /// Where no image holds in motion (holdsInMotion), that is all that the frustum may hold.
  void run(Answer& answer);

 private:
  bool mayGoOn() { return budget_.mayGoOn(countedNs()); }
  void beginFrame();
  void drawWhatWasVisible();
  void walk();
  void visit(const ZPyramidVisit& from);
  void takeObjects(const ZPyramidVisit& from, std::uint32_t visit);
  void takeObject(ZPyramidBox box, std::uint32_t visit, ObjectId id, bool blocking);
  void pushChildren(const ZPyramidVisit& from, std::uint32_t visit);
  template <typename Take>
  void forEachChild(const OctreeNode& node, PlaneMask planes, const Take& take);
  bool hides(ZPyramidBox& box);
  void takeOccluder(ObjectId id);
  bool ownBox(ObjectId id, ZPyramidBox& box) const;
  void bringPyramidUpToDate();
  bool settle(Answer& answer);
  void askByTriangles(Answer& answer);
  bool hiddenByItsTriangles(ObjectId id);
  void keepTheRest(Answer& answer);
  void keep(ObjectId id, Answer& answer);
  std::uint64_t countedNs() const;  ///< work beside drawing
  std::uint32_t nearestOctant(const glm::dvec3& centre) const;

  const SceneSnapshot& scene_;
  const Octree& octree_;
  const OccluderSet& occluders_;
  const ZPyramidParts& parts_;
  const Deadline& deadline_;
  WorkBudget budget_;
  ZPyramidMemory& memory_;
  FrustumTest frustum_;
  CellView view_;
  CellView asked_view_;  ///< the same, for what is asked instead of drawn
  BoxView box_view_;
  glm::dvec3 eye_world_, toward_eye_;  ///< the second for an orthographic camera
  bool perspective_;
  OccluderDrawing drawing_;
  bool ask_triangles_;
  bool coherent_;
  bool occlusion_;
  bool pyramid_is_old_ = false;  ///< only without the incremental update
  std::uint64_t asking_ns_ = 0, saved_ns_ = 0;
  CullStats stats_;
};

}  // namespace culld
