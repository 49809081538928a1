// One frame of method `gpu-depth-pyramid`.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/culler.h"
#include "culling/gpu/depth_pass.h"
#include "culling/methods/gpu_depth_pyramid_occluders.h"
#include "culling/raster/box_kernels.h"
#include "culling/raster/cell_view.h"
#include "culling/spatial/frustum_test.h"
#include "culling/spatial/wide_bvh.h"
#include "culling/work_budget.h"

namespace culld {

/// Parts of the method that settings turn on and off.
struct GpuDepthPyramidParts {
  bool coherence = true;     ///< the last frame's visible occluders are drawn first
  std::uint32_t refine = 2;  ///< finer levels asked
  std::uint32_t faces = 16;  ///< of a mesh without convex pieces
};

/// Kept from frame to frame: what was visible, to draw it first; the rest for its memory only.
struct GpuDepthPyramidMemory final : ViewState::Memory {
  std::vector<std::uint32_t> kept_in;  ///< by object, the last frame that answered it
  std::uint32_t frame = 0;
  struct Lanes {
    std::uint8_t objects, blocking, drawn;  ///< bits as the lanes of a node
  };
  std::vector<gpu::GroupQuery> queries, left;  ///< those of `queries` ask for some of the objects
  std::vector<Lanes> lanes;                    ///< by query
  std::vector<std::uint32_t> left_of;          ///< by entry of `left`: its place in `queries`
  std::vector<std::uint32_t> hidden, hidden_after;
  gpu::OutlineBatch batch;
  bool sceneEdited() override { return true; }  // ids stay, and what was visible is only a guess
};

class GpuDepthPyramidFrame {
 public:
  GpuDepthPyramidFrame(const SceneSnapshot& scene, const WideBvh& bvh,
                       const GpuOccluders& occluders, const GpuDepthPyramidParts& parts,
                       const Camera& camera, const Deadline& deadline, const Demand& demand,
                       GpuDepthPyramidMemory& memory);

  /// False: the image has more cells than the GPU holds, and run() may not be called.
  bool fits(std::size_t most_buffer_bytes) const noexcept;
  /// Appends the objects not proven hidden, in no particular order. `source`: the tree's nodes.
  /// ERROR: kUnavailable: the GPU failed, and the answer is not to be used.
  Result<void> run(gpu::ContextPool::Lease& gpu, const gpu::GroupSource& source, Answer& answer);

 private:
  void collect(Answer& answer);
  void addQuery(std::uint32_t index, const WideNode& node, std::uint32_t objects);
  template <typename Wanted>
  std::uint32_t drawOccluders(gpu::DepthPass& pass, const Wanted& wanted);
  void drawObject(gpu::DepthPass& pass, ObjectId id);
  void flush(gpu::DepthPass& pass);
  void testAll(gpu::DepthPass& pass, const gpu::GroupSource& source);
  void testTheRest(gpu::DepthPass& pass, const gpu::GroupSource& source);
  void answerTheRest(Answer& answer);
  std::uint32_t hiddenLanes(std::size_t query) const;
  bool mayGoOn() { return budget_.mayGoOn(countedNs()); }
  std::uint64_t countedNs() const;

  const SceneSnapshot& scene_;
  const WideBvh& bvh_;
  const GpuOccluders& occluders_;
  const GpuDepthPyramidParts& parts_;
  WorkBudget budget_;
  GpuDepthPyramidMemory& memory_;
  FrustumTest frustum_;
  CellView view_;
  BoxView box_view_;
  glm::dvec3 eye_world_;
  float largest_row_;  ///< of all coefficients of the view
  bool coherent_;
  std::uint64_t pieces_ = 0;
  CullStats stats_;
};

}  // namespace culld
