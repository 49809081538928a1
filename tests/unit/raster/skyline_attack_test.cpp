// Attacks the rows that an object hides in each column: see cell_attack.h. Their very ends are
// judged, at both sides of the column.
#include "culling/raster/sheet_skyline.h"
#include "tests/scenes/rounds.h"
#include "tests/unit/raster/cell_attack.h"

namespace culld {
namespace {

class SkylineAttack : public CellAttack {
 protected:
  void draw(const Mesh&, const std::array<double, 12>&, const CellView&, const glm::dvec3&,
            DepthCells&) override {}

  void drawAndJudge(const Mesh& drawn, const std::array<double, 12>& m,
                    const Camera& camera) override {
    const CellView view = cellView(camera, gridFor(camera));
    std::vector<SheetSurface> surfaces;
    for (const Surface& s : drawn.surfaces) {
      surfaces.push_back({s.first_triangle, s.triangle_count, s.double_sided});
    }
    const glm::dvec3 largest = glm::max(glm::abs(drawn.bounds.min), glm::abs(drawn.bounds.max));
    const Deadline never(steadyClock(), {}, {});
    slices_.clear();
    const auto columns = static_cast<std::uint32_t>(random_() % 3 * 8);
    skyline_.append({drawn.positions, drawn.triangles, drawn.partners, surfaces, m, largest, 1e30F},
                    view, camera.origin_world, columns, never, slices_);
    const TrueView true_view(camera, view.grid);
    const TrueObject object(drawn, m, camera.origin_world);
    for (int i = 0; i < 8 && !slices_.slices.empty(); ++i) {
      judgeSlice(true_view, object, slices_.slices[random_() % slices_.slices.size()]);
    }
  }

  void judgeSlice(const TrueView& view, const TrueObject& object, const HorizonSlice& slice) {
    const std::uint32_t at = static_cast<std::uint32_t>(random_() % slice.columns);
    const RowSpan span = slices_.spansOf(slice)[at];
    if (span.empty() || !(slice.nearness > 0.0F)) return;
    ++columns_;
    for (int k = 0; k < 6; ++k) {
      const Quad s = slice.first_column + at + (k < 4 ? Quad(k % 2) : Quad(real(0.0, 1.0)));
      const float along = k < 4 ? static_cast<float>(k / 2) : static_cast<float>(real(0.0, 1.0));
      const Quad t = Quad(span.low) + Quad(along) * (Quad(span.high) - Quad(span.low));
      ASSERT_GE(object.blockedAt(view, view.through(s, t)), Quad(slice.nearness))
          << "column " << slice.first_column + at << ", place " << k;
    }
  }

  std::size_t columns_ = 0;
  HorizonSlices slices_;
  SheetSkyline skyline_;
};

TEST_F(SkylineAttack, EveryRayThroughHiddenRowsMeetsTheObjectAtLeastAsNear) {
  for (std::uint64_t seed = 1; seed <= scenes::rounds(4000) && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    begin(seed);
    attackOnce();
  }
  std::printf("%zu columns judged\n", columns_);
  EXPECT_GT(columns_, scenes::rounds(2500));
}

TEST_F(SkylineAttack, AlsoWhereCancellationLeavesVerticesFewDigits) {
  for (std::uint64_t seed = 1; seed <= scenes::rounds(3000) && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    begin(seed);
    attackCancellation();
  }
  std::printf("%zu columns judged\n", columns_);
  EXPECT_GT(columns_, scenes::rounds(1000));
}

}  // namespace
}  // namespace culld
