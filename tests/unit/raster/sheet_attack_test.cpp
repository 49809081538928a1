// Attacks the sheet rasterizer: see cell_attack.h.
#include "culling/raster/sheet.h"
#include "tests/unit/raster/cell_attack.h"

namespace culld {
namespace {

class SheetAttack : public CellAttack {
 protected:
  void draw(const Mesh& mesh, const std::array<double, 12>& world_from_mesh, const CellView& view,
            const glm::dvec3& eye, DepthCells& cells) override {
    std::vector<SheetSurface> surfaces;
    for (const Surface& s : mesh.surfaces) {
      surfaces.push_back({s.first_triangle, s.triangle_count, s.double_sided});
    }
    const glm::dvec3 largest = glm::max(glm::abs(mesh.bounds.min), glm::abs(mesh.bounds.max));
    const Deadline never(steadyClock(), {}, {});
    rasterizer_.draw(
        {mesh.positions, mesh.triangles, mesh.partners, surfaces, world_from_mesh, largest, 1e30F},
        view, eye, never, cells);
  }

 private:
  SheetRasterizer rasterizer_;
};

TEST_F(SheetAttack, EveryRayThroughACoveredCellMeetsTheObjectAtLeastAsNear) {
  for (std::uint64_t seed = 1; seed <= 1000 && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    begin(seed);
    attackOnce();
  }
  std::printf("%zu cells judged\n", cells_);
  EXPECT_GT(cells_, 1500U);
}

TEST_F(SheetAttack, AlsoWhereCancellationLeavesVerticesFewDigits) {
  for (std::uint64_t seed = 1; seed <= 1200 && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    begin(seed);
    attackCancellation();
  }
  std::printf("%zu cells judged\n", cells_);
  EXPECT_GT(cells_, 1500U);
}

}  // namespace
}  // namespace culld
