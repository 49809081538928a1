// The scalar truth of depth_pass.h: the same operations in the same order on the CPU. What a GPU
// is held against when it is opened, and in tests.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "culling/gpu/depth_pass.h"

namespace culld::gpu {

class DepthReference {
 public:
  void begin(const CellGrid& grid);
  void draw(const OutlineBatch& batch);
  void buildPyramid();
  void test(const BoxView& view, std::span<const BoxGroup> groups,
            std::span<const GroupQuery> queries, std::uint32_t refine,
            std::vector<std::uint32_t>& hidden) const;
  const PyramidLayout& layout() const noexcept { return layout_; }
  /// All levels, as layout() has them; what stands for no cell of the grid is NaN above level 0.
  std::span<const float> pyramid() const noexcept { return cells_; }

 private:
  bool hides(std::uint32_t level, const CellRect& rect, float nearest) const;
  void raise(const OutlineBatch& batch, const OutlineHead& head, std::uint32_t x, std::uint32_t y);

  CellGrid grid_;
  PyramidLayout layout_;
  std::vector<float> cells_;
};

}  // namespace culld::gpu
