// Attacks error-model/gpu.md §2 from matrices to cells: what a shader covers, computed by the
// reference that it equals, must be covered by the true object and at least as near, and hidden
// behind it from every eye within a motion bound. See cell_attack.h, motion_attack.h.
#include "culling/gpu/depth_reference.h"
#include "culling/occluders/convex_pieces.h"
#include "tests/unit/raster/motion_attack.h"

namespace culld::gpu {
namespace {

template <typename Attack>
class WithOutlines : public Attack {
 protected:
  void draw(const Mesh& mesh, const std::array<double, 12>& world_from_mesh, const CellView& view,
            const glm::dvec3& eye, DepthCells& cells) override {
    const auto [wanted, rows] = Attack::placedIn(view, mesh, world_from_mesh, eye);
    if (wanted == 0) return;
    const ConvexPieces whole = ConvexPieces::of(mesh);
    const ConvexPieces pieces = whole.size() != 0 ? whole : ConvexPieces::facesOf(mesh, 16);
    OutlineBatch batch;
    ConvexOutline outline;
    for (std::size_t i = 0; i < pieces.size(); ++i) {
      const OutlineVerdict verdict =
          outlineOf(pieces[i], rows, view.grid, view.perspective, wanted, outline);
      if (verdict == OutlineVerdict::kDraw) batch.add(outline, view.grid);
    }
    drawn_ += batch.heads.size();
    DepthReference reference;
    reference.begin(view.grid);
    reference.draw(batch);
    const PyramidLayout& layout = reference.layout();
    for (std::uint32_t y = 0; y < view.grid.height; ++y) {
      for (std::uint32_t x = 0; x < view.grid.width; ++x) {
        const float nearness = reference.pyramid()[y * layout.width[0] + x];
        if (!(nearness > 0.0F)) continue;
        cells.cells(view.grid.blockAt(x / 8, y / 8))[y % 8 * 8 + x % 8] = nearness;
      }
    }
  }

  std::size_t drawn_ = 0;
};

using GpuOutlineAttack = WithOutlines<CellAttack>;
using GpuMotionAttack = WithOutlines<MotionAttack>;

TEST_F(GpuOutlineAttack, EveryRayThroughACoveredCellMeetsTheObjectAtLeastAsNear) {
  for (std::uint64_t seed = 1; seed <= 800 && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    begin(seed);
    attackOnce();
  }
  std::printf("%zu outlines, %zu cells judged\n", drawn_, cells_);
  EXPECT_GT(drawn_, 250U);
  EXPECT_GT(cells_, 500U);
}

TEST_F(GpuOutlineAttack, AlsoWhereCancellationLeavesVerticesFewDigits) {
  for (std::uint64_t seed = 1; seed <= 300 && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    begin(seed);
    attackCancellation();
  }
  std::printf("%zu outlines, %zu cells judged\n", drawn_, cells_);
  EXPECT_GT(drawn_, 50U);
}

TEST_F(GpuMotionAttack, WhatLiesBehindACoveredCellIsHiddenFromEveryPose) {
  attackSeeds(1600);
  std::printf("%zu outlines, %zu cells judged\n", drawn_, cells_);
  EXPECT_GT(drawn_, 250U);
  EXPECT_GT(cells_, 500U);
}

TEST_F(GpuMotionAttack, WouldNoticeEdgesThatDoNotSway) {
  forget_motion_ = true;
  attackSeeds(400);
  EXPECT_GT(open_, 100U);
}

}  // namespace
}  // namespace culld::gpu
