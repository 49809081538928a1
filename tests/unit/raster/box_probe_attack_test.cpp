// Attacks docs/error-model/z-pyramid.md §1: wherever a point of a box is seen, the box must not be
// called beside that cell, nor farther than the point. Judged in 113-bit arithmetic.
#include "culling/raster/box_probe.h"
#include "tests/scenes/rounds.h"
#include "tests/unit/raster/cell_attack.h"

namespace culld {
namespace {

class BoxProbeAttack : public CellAttack {
 protected:
  void draw(const Mesh&, const std::array<double, 12>&, const CellView&, const glm::dvec3&,
            DepthCells&) override {}

  void attackBox() {
    const double reach = chance(3) ? 1e7 : chance(2) ? 1e3 : 0.0;
    const double distance = std::exp2(real(-7.0, 7.0));
    const glm::dvec3 eye(real(-reach, reach), real(-reach, reach), real(-reach, reach));
    const glm::dvec3 ahead = glm::normalize(glm::dvec3(real(-0.3, 0.3), real(-0.3, 0.3), -1.0));
    const Camera camera =
        chance(2) ? lookAt(eye, eye + distance * ahead, distance) : matrices(eye, distance);
    makeBox(eye + distance * ahead, distance * fov_ * std::exp2(real(-5.0, 1.0)), camera);
    const CellView view = cellView(camera, gridFor(camera));
    const std::array<double, 3> from{origin_[0] - camera.origin_world.x,
                                     origin_[1] - camera.origin_world.y,
                                     origin_[2] - camera.origin_world.z};
    BoxRects rects;
    projectBoxes(boxView(view), from, offsets_, rects);
    if ((rects.off_grid & 1U) != 0) return;
    BoxProbe probe;
    probe.rect = {0, view.grid.width - 1, 0, view.grid.height - 1};
    probe.nearest = rects.nearest[0];
    addFaces(view, camera.origin_world, origin_, offsets_, 0, probe);
    sides_ += probe.side_count;
    faces_ += probe.face_count;
    judgeBox(TrueView(camera, view.grid), camera, view.grid, probe);
  }

  /// Now and then flat, thin, or in line with the eye.
  void makeBox(const glm::dvec3& at, double size, const Camera& camera) {
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<int>(i);
      origin_[i] = at[axis] + (chance(3) ? 0.0 : size * real(-1.0, 1.0));
      const double thin = chance(6) ? (chance(2) ? 0.0 : std::exp2(real(-40.0, -5.0))) : 1.0;
      float low = static_cast<float>(-size * thin * real(0.0, 1.0));
      float high = static_cast<float>(size * thin * real(0.0, 1.0));
      // A face in the eye's own plane, to the last bits.
      if (chance(8)) low = static_cast<float>(camera.origin_world[axis] - origin_[i]);
      if (low > high) std::swap(low, high);
      for (std::size_t l = 0; l < kBoxLanes; ++l) {
        offsets_[i][l] = low;
        offsets_[i + 3][l] = high;
      }
    }
  }

  void judgeBox(const TrueView& view, const Camera& camera, const CellGrid& grid,
                const BoxProbe& probe) {
    for (int k = 0; k < 40; ++k) {
      Vec p;
      for (Quad* coordinate : {&p.x, &p.y, &p.z}) {
        const std::size_t i = coordinate == &p.x ? 0 : coordinate == &p.y ? 1 : 2;
        const double t = chance(2) ? real(0.0, 1.0) : chance(2) ? 0.0 : 1.0;  // corners and edges
        const Quad low = offsets_[i][0], high = offsets_[i + 3][0];
        *coordinate = Quad(origin_[i]) - camera.origin_world[static_cast<int>(i)] + low +
                      Quad(t) * (high - low);
      }
      if (!view.betweenClipPlanes(p)) continue;
      const Quad column = view.column(p), row = view.row(p);
      if (!(column > 0 && row > 0 && column < grid.width && row < grid.height)) continue;
      const auto x = static_cast<std::uint32_t>(column), y = static_cast<std::uint32_t>(row);
      ++points_;
      const Quad nearness = view.nearness(p);
      for (const CellRect& cells : {CellRect{x, x, y, y}, CellRect{x, x + 3, y, y + 5}}) {
        ASSERT_FALSE(probe.besides(cells));
        ASSERT_GE(Quad(probe.nearestOver(cells)), nearness);
      }
    }
  }

  std::array<double, 3> origin_{};
  float offsets_[6][kBoxLanes]{};
  std::size_t points_ = 0, sides_ = 0, faces_ = 0;
};

TEST_F(BoxProbeAttack, NoPointOfABoxIsBesideItOrNearerThanItsFaces) {
  constexpr std::size_t kBoxes = scenes::rounds(30'000);
  for (std::uint64_t seed = 1; seed <= kBoxes && !HasFatalFailure(); ++seed) {
    begin(seed);
    attackBox();
  }
  EXPECT_GT(points_, 10 * kBoxes);
  EXPECT_GT(sides_, 2 * kBoxes);
  EXPECT_GT(faces_, kBoxes);
}

TEST(BoxProbe, TellsWhatItsRectangleDoesNot) {
  LookAt look;
  look.eye = {5.0, 5.0, 5.0};
  look.target = {0.0, 0.0, 0.0};
  const Camera camera = cameraFromLookAt(look, {640, 360}).value();
  const CellView view = cellView(camera, gridFor(camera));
  float offsets[6][kBoxLanes];
  for (std::size_t l = 0; l < kBoxLanes; ++l) {
    for (std::size_t i = 0; i < 3; ++i) {
      offsets[i][l] = -1.0F;
      offsets[i + 3][l] = 1.0F;
    }
  }
  BoxRects rects;
  projectBoxes(boxView(view), {-5.0, -5.0, -5.0}, offsets, rects);
  BoxProbe probe;
  probe.rect = {static_cast<std::uint32_t>(rects.x0[0]), static_cast<std::uint32_t>(rects.x1[0]),
                static_cast<std::uint32_t>(rects.y0[0]), static_cast<std::uint32_t>(rects.y1[0])};
  probe.nearest = rects.nearest[0];
  addFaces(view, camera.origin_world, {0.0, 0.0, 0.0}, offsets, 0, probe);
  EXPECT_EQ(probe.side_count, 6U);
  EXPECT_EQ(probe.face_count, 3U);
  // A corner-on cube is a hexagon: it does not reach the corners of its rectangle.
  EXPECT_TRUE(probe.besides({probe.rect.x0, probe.rect.x0, probe.rect.y0, probe.rect.y0}));
  EXPECT_FALSE(probe.besides({319, 320, 179, 180}));
  // It is nearest in the middle, and farther at its outline.
  EXPECT_LT(probe.nearestOver({probe.rect.x0 + 4, probe.rect.x0 + 5, 180, 180}),
            0.9F * probe.nearestOver({320, 320, 180, 180}));
}

}  // namespace
}  // namespace culld
