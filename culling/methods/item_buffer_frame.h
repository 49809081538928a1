// One frame of method `item-buffer`.
#pragma once
#include <chrono>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "culling/culler.h"
#include "culling/gpu/item_pass.h"
#include "culling/methods/item_buffer_meshes.h"
#include "culling/raster/cell_view.h"
#include "culling/raster/object_rows.h"
#include "culling/work_budget.h"

namespace culld {

/// Parts of the method that settings turn on and off.
struct ItemBufferParts {
  std::uint32_t lattice = 1;  ///< samples along each side of a pixel
  bool ties = true;           ///< surfaces at the depth of what hides them are answered too
};

/// Pixels that show objects, by ascending id; of those only that were drawn and found.
using ItemPixels = std::vector<std::pair<ObjectId, float>>;

class ItemBufferFrame {
 public:
  /// REQUIRES: a camera that stands still.
  ItemBufferFrame(const SceneSnapshot& scene, const ItemMeshes& meshes,
                  const ItemBufferParts& parts, const Camera& camera, const Deadline& deadline,
                  std::chrono::nanoseconds most_work);

  /// False: the image has more samples than are drawn, and run() may not be called.
  static bool fits(const Camera& camera, std::uint32_t lattice) noexcept;

  /// Leaves of the objects in `answer.visible`, distinct and in any order, those that a sample
  /// shows or that cannot be drawn; all of them if it runs out of time.
  /// ERROR: kUnavailable: the GPU failed, and the answer is as it was.
  Result<ItemPixels> run(gpu::ContextPool::Lease& gpu, Answer& answer);

 private:
  /// Its place in items_ is its number.
  struct Drawn {
    std::int8_t facing;  ///< sign that its fronts have in the image; 0: cannot be told
    MeshId mesh;
    ObjectId id;
    auto operator<=>(const Drawn&) const = default;
  };
  enum class Part : std::uint8_t { kBlocking, kShowing };

  void sortOut(std::span<const ObjectId> found);
  void drawAll(gpu::ItemPass& pass);
  template <typename Wanted>
  void draw(gpu::ItemPass& pass, gpu::ItemPass::Stage stage, Part part, const Wanted& wanted);
  void add(std::uint32_t number, Part part);
  void flush(gpu::ItemPass& pass, gpu::ItemPass::Stage stage);
  ItemPixels report(Answer& answer);
  ObjectRows rowsOf(const Instance& instance) const;
  bool isDrawable(const ObjectRows& rows, const glm::dvec3& largest) const;
  std::uint64_t countedNs() const;

  const SceneSnapshot& scene_;
  const ItemMeshes& meshes_;
  gpu::MeshSource source_;
  const ItemBufferParts& parts_;
  WorkBudget budget_;
  glm::dvec3 eye_world_;
  std::uint32_t width_, height_;  ///< samples
  CellView view_;                 ///< u and v are clip coordinates
  std::vector<Drawn> items_;
  std::vector<ObjectId> kept_;         ///< whatever is drawn
  std::vector<std::uint32_t> counts_;  ///< samples, by number
  CullStats stats_;
  std::uint64_t triangles_ = 0, items_drawn_ = 0;
  // What is not given to the GPU so far.
  std::vector<gpu::Item> batch_;
  std::vector<gpu::ItemDraw> draws_;
  std::size_t group_draws_ = 0;  ///< of the last item, at the end of draws_
  std::uint64_t batch_triangles_ = 0;
};

}  // namespace culld
