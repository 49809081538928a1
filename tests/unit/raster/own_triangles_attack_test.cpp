// Attacks docs/error-model.md §5.2: whatever of an object can be seen, if only in one point on the
// rim of one cell, keeps it. Judged in 113-bit arithmetic.
#include "culling/raster/own_triangles.h"

#include "culling/raster/occludee_kernels.h"
#include "tests/unit/raster/cell_attack.h"

namespace culld {
namespace {

/// The largest float that is not nearer.
float notNearer(Quad nearness) {
  auto f = static_cast<float>(nearness);
  while (Quad(f) > nearness) f = std::nextafter(f, -HUGE_VALF);
  return f;
}

/// A point of an object that its camera sees.
struct SeenPoint {
  std::uint32_t triangle = 0;
  std::array<double, 3> weight{};
  Quad column = 0, row = 0, nearness = 0;
};

/// Every cell hides whatever comes, but for the one that holds a point of the object, which is at
/// that point's depth.
class OwnTrianglesAttack : public CellAttack {
 protected:
  void draw(const Mesh& /*mesh*/, const std::array<double, 12>& /*world_from_mesh*/,
            const CellView& /*view*/, const glm::dvec3& /*eye*/, DepthCells& /*cells*/) override {
    FAIL() << "the cells are made by hand";
  }

  void drawAndJudge(const Mesh& mesh, const std::array<double, 12>& m,
                    const Camera& camera) override {
    const CellView view = cellView(camera, gridFor(camera));
    const TrueView truth(camera, view.grid);
    const std::array<double, 12> as_placed = chance(4) ? turnedToTheEye(m, camera) : m;
    for (int k = 0; k < 12; ++k) {
      std::array<double, 12> place = as_placed;
      SeenPoint point = randomPoint(mesh);
      if (!seen(truth, view.grid, mesh, place, camera, point)) continue;
      if (chance(2)) {
        toARim(camera, point, place);
        if (!seen(truth, view.grid, mesh, place, camera, point)) continue;
      }
      judgePoint(mesh, place, camera, view, point);
      if (HasFatalFailure()) return;
    }
    judgeRays(mesh, as_placed, camera, view);
  }

  /// Its xy plane about parallel to the image: all of a face at one depth, where a cell's width
  /// hides no error.
  std::array<double, 12> turnedToTheEye(std::array<double, 12> m, const Camera& camera) {
    const double size = glm::length(glm::dvec3(m[0], m[4], m[8]));
    const glm::dvec3 toward =
        camera.perspective ? -glm::dvec3(camera.w_row) : glm::dvec3(camera.near_row);
    const double tilt = std::exp2(real(-32.0, -18.0));
    const glm::dvec3 z =
        glm::normalize(glm::normalize(toward) + tilt * glm::dvec3(real(-1.0, 1.0)));
    const glm::dvec3 x = glm::normalize(glm::cross(glm::dvec3(camera.y_row), z));
    const glm::dvec3 y = glm::cross(z, x);
    for (std::size_t r = 0; r < 3; ++r) {
      const int axis = static_cast<int>(r);
      m[4 * r] = size * x[axis];
      m[4 * r + 1] = size * y[axis];
      m[4 * r + 2] = size * z[axis];
    }
    return m;
  }

  /// Points where rays first meet the object, also where few of its points are on the image.
  void judgeRays(const Mesh& mesh, const std::array<double, 12>& m, const Camera& camera,
                 const CellView& view) {
    const TrueView truth(camera, view.grid);
    const TrueObject object(mesh, m, camera.origin_world);
    for (int k = 0; k < 6 && !HasFatalFailure(); ++k) {
      SeenPoint point;
      point.column = real(0.0, view.grid.width);
      point.row = real(0.0, view.grid.height);
      if (chance(2)) point.column = Quad(0.5 * view.grid.width) + real(-2.0, 2.0);
      if (chance(2)) point.row = Quad(0.5 * view.grid.height) + real(-2.0, 2.0);
      point.nearness = object.blockedAt(truth, truth.through(point.column, point.row));
      if (point.nearness > 0) judgePoint(mesh, m, camera, view, point);
    }
  }

  SeenPoint randomPoint(const Mesh& mesh) {
    SeenPoint point;
    point.triangle = static_cast<std::uint32_t>(random_() % mesh.triangles.size());
    double total = 0.0;
    for (double& w : point.weight) {
      w = chance(3) ? 0.0 : real(0.0, 1.0);  // corners and edges often
      total += w;
    }
    if (total == 0.0) point.weight[0] = 1.0;
    return point;
  }

  static bool doubleSided(const Mesh& mesh, std::uint32_t triangle) {
    for (const Surface& s : mesh.surfaces) {
      if (triangle - s.first_triangle < s.triangle_count) return s.double_sided;
    }
    return false;
  }

  /// Fills in where the point lies. False if the camera does not see it.
  static bool seen(const TrueView& truth, const CellGrid& grid, const Mesh& mesh,
                   const std::array<double, 12>& place, const Camera& camera, SeenPoint& point) {
    const TrueObject object(mesh, place, camera.origin_world);
    const auto corner = object.triangle(point.triangle);
    const std::array<double, 3>& w = point.weight;
    const Quad total = Quad(w[0]) + w[1] + w[2];
    const Vec p = (Quad(w[0]) / total) * corner[0] + (Quad(w[1]) / total) * corner[1] +
                  (Quad(w[2]) / total) * corner[2];
    if (!truth.betweenClipPlanes(p)) return false;
    point.column = truth.column(p);
    point.row = truth.row(p);
    point.nearness = truth.nearness(p);
    const bool on_image =
        point.column >= 0 && point.column < grid.width && point.row >= 0 && point.row < grid.height;
    if (!on_image || !(point.nearness > 0)) return false;
    return doubleSided(mesh, point.triangle) ||
           object.front(corner, truth.through(point.column, point.row));
  }

  /// Moves the object so that the point comes to lie within ulps of a rim between two cells.
  void toARim(const Camera& camera, const SeenPoint& point, std::array<double, 12>& place) {
    const glm::dvec3 along = glm::normalize(glm::dvec3(camera.x_row));
    const CellGrid grid = gridFor(camera);
    const double column = static_cast<double>(point.column);
    const double x_per_metre = glm::dot(glm::dvec3(camera.x_row), along) * 0.5 * grid.width;
    const double w = camera.perspective ? glm::length(glm::dvec3(camera.w_row)) /
                                              static_cast<double>(point.nearness)
                                        : 1.0;
    const double metres = (std::round(column) - column) * w / x_per_metre;
    for (std::size_t r = 0; r < 3; ++r) {
      double& x = place[4 * r + 3];
      x += metres * along[static_cast<int>(r)];
      for (std::uint64_t i = random_() % 3; i > 0; --i)
        x = std::nextafter(x, chance(2) ? HUGE_VAL : -HUGE_VAL);
    }
  }

  void judgePoint(const Mesh& mesh, const std::array<double, 12>& place, const Camera& camera,
                  const CellView& view, const SeenPoint& point) {
    const auto i = static_cast<std::uint32_t>(point.column);
    const auto j = static_cast<std::uint32_t>(point.row);
    const float z = chance(4) ? 0.0F : notNearer(point.nearness);
    ASSERT_FALSE(hidden(mesh, place, camera, view, i, j, z))
        << "cell " << i << ", " << j << " at " << z;
    ++points_;
    hidden_otherwise_ += hidden(mesh, place, camera, view, i, j, kNearest);
  }

  bool hidden(const Mesh& mesh, const std::array<double, 12>& place, const Camera& camera,
              const CellView& view, std::uint32_t i, std::uint32_t j, float z) {
    cells_made_.reset(view.grid);
    for (std::uint32_t y = 0; y < view.grid.blocks_y; ++y) {
      for (std::uint32_t x = 0; x < view.grid.blocks_x; ++x) {
        cells_made_.setLeastNearness(view.grid.blockAt(x, y), kNearest);
      }
    }
    const std::uint32_t block = view.grid.blockAt(i / 8, j / 8);
    float* nearness = cells_made_.cells(block);
    std::fill(nearness, nearness + 64, kNearest);
    nearness[j % 8 * 8 + i % 8] = z;
    cells_made_.setLeastNearness(block, chance(2) ? 0.0F : z);
    std::vector<SheetSurface> surfaces;
    for (const Surface& s : mesh.surfaces) {
      surfaces.push_back({s.first_triangle, s.triangle_count, s.double_sided});
    }
    const glm::dvec3 largest = glm::max(glm::abs(mesh.bounds.min), glm::abs(mesh.bounds.max));
    const Deadline never(steadyClock(), {}, {});
    return ownTrianglesHidden(
               {mesh.positions, mesh.triangles, mesh.partners, surfaces, place, largest, kNearest},
               view, camera.origin_world, never, 1'000'000'000, cells_made_)
        .hidden;
  }

  static constexpr float kNearest = 3.0e38F;
  DepthCells cells_made_;
  std::size_t points_ = 0, hidden_otherwise_ = 0;
};

TEST_F(OwnTrianglesAttack, OnePointInAnOpenCellKeepsTheObject) {
  for (std::uint64_t seed = 1; seed <= 4000 && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    begin(seed);
    attackOnce();
  }
  std::printf("%zu points, %zu objects hidden where they should be\n", points_, hidden_otherwise_);
  EXPECT_GT(points_, 5000U);
  EXPECT_GT(hidden_otherwise_, points_ / 2);
}

TEST_F(OwnTrianglesAttack, AlsoWhereCancellationLeavesVerticesFewDigits) {
  for (std::uint64_t seed = 1; seed <= 2000 && !HasFatalFailure(); ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    begin(seed);
    attackCancellation();
  }
  std::printf("%zu points, %zu objects hidden where they should be\n", points_, hidden_otherwise_);
  EXPECT_GT(points_, 500U);
}

/// The kernel by itself: true vertices anywhere within the stated errors.
class RectAttack : public ::testing::Test {
 protected:
  static constexpr double kSide = 48.0;

  struct TrueCorner {
    Quad u, v, w, n, near_cut, far_cut;
  };

  double real(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  bool chance(unsigned one_in) { return random_() % one_in == 0; }

  /// Mesh space is cells times w, w (or, orthographic, nearness): the rows only pick coordinates.
  void next() {
    depth_ = std::exp2(real(-6.0, 12.0));
    view_.perspective = !chance(3);
    view_.width = view_.height = kSide;
    ObjectRows& rows = view_.rows;
    rows.u = {1, 0, 0, 0};
    rows.v = {0, 1, 0, 0};
    rows.w = view_.perspective ? ObjectRow{0, 0, 1, 0} : ObjectRow{0, 0, 0, 1};
    rows.n = view_.perspective ? ObjectRow{0, 0, 0, 1} : ObjectRow{0, 0, 1, 0};
    rows.near_cut = view_.perspective ? ObjectRow{0, 0, 1, -0.3 * depth_} : ObjectRow{0, 0, -1, 1};
    rows.far_cut = view_.perspective ? ObjectRow{0, 0, -1, 1.6 * depth_} : ObjectRow{0, 0, 1, 0};
    std::array<double, 3> largest{};
    for (std::size_t lane = 0; lane < kTriangleLanes; ++lane) makeLane(lane, largest);
    const double relative = chance(3) ? 1e-4 : chance(2) ? 1e-9 : 0x1p-48;
    const double w = view_.perspective ? largest[2] : 1.0;
    rows.error = {relative * largest[0],
                  relative * largest[1],
                  relative * w,
                  view_.perspective ? 0.0 : relative * std::max(largest[2], 1.0),
                  relative * (largest[2] + depth_ + 1.0),
                  relative * (largest[2] + depth_ + 1.0),
                  {}};
  }

  float coordinate() {
    double x = real(-10.0, kSide + 10.0);
    if (chance(2)) x = std::round(x);
    if (chance(12)) x *= 1e6;
    return static_cast<float>(x);
  }

  void makeLane(std::size_t lane, std::array<double, 3>& largest) {
    auto& at = triangles_.coordinate;
    for (std::size_t c = 0; c < 3; ++c) {
      const double w = depth_ * (chance(4) ? real(-1.0, 1.0) : real(0.5, 2.0));
      const float scale = view_.perspective ? static_cast<float>(w) : 1.0F;
      at[3 * c][lane] = coordinate() * scale;
      at[3 * c + 1][lane] = coordinate() * scale;
      at[3 * c + 2][lane] = view_.perspective ? scale : static_cast<float>(real(-0.2, 1.2));
    }
    if (chance(4)) {  // a sliver: rounding decides which side it turns
      const auto part = static_cast<float>(real(0.0, 1.0));
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const float p = at[axis][lane], q = at[3 + axis][lane];
        at[6 + axis][lane] = p + part * (q - p);
      }
    }
    for (std::size_t i = 0; i < 9; ++i) {
      largest[i % 3] = std::max(largest[i % 3], std::abs(double{at[i][lane]}));
    }
  }

  Quad moved(double x, double by) {
    const std::uint64_t choice = random_() % 4;
    if (choice == 0) return Quad(x) + Quad(by);
    if (choice == 1) return Quad(x) - Quad(by);
    return Quad(x) + Quad(by) * Quad(real(-1.0, 1.0));
  }

  std::array<TrueCorner, 3> trueCorners(std::size_t lane) {
    const ObjectRows& rows = view_.rows;
    std::array<TrueCorner, 3> out;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto& at = triangles_.coordinate;
      const CellVertex p = rows.at({at[3 * c][lane], at[3 * c + 1][lane], at[3 * c + 2][lane]});
      const CellVertexError& e = rows.error;
      out[c] = {moved(p.u, e.u),
                moved(p.v, e.v),
                view_.perspective ? moved(p.w, e.w) : Quad(1),
                moved(p.n, e.n),
                moved(p.near_cut, e.near_cut),
                moved(p.far_cut, e.far_cut)};
    }
    return out;
  }

  void judge(std::size_t lane, double front, const TriangleRects& rects) {
    const auto p = trueCorners(lane);
    const Quad det = p[0].u * (p[1].v * p[2].w - p[1].w * p[2].v) +
                     p[0].v * (p[1].w * p[2].u - p[1].u * p[2].w) +
                     p[0].w * (p[1].u * p[2].v - p[1].v * p[2].u);
    if (front != 0.0 && !(det * Quad(front) > 0)) return;
    for (int k = 0; k < 6; ++k) {
      TrueCorner sum{};
      Quad total = 0;
      for (const TrueCorner& c : p) {
        const Quad weight = chance(3) ? 0.0 : real(0.0, 1.0);
        total += weight;
        sum = {sum.u + weight * c.u,
               sum.v + weight * c.v,
               sum.w + weight * c.w,
               sum.n + weight * c.n,
               sum.near_cut + weight * c.near_cut,
               sum.far_cut + weight * c.far_cut};
      }
      if (!(total > 0) || !(sum.w > 0) || !(sum.near_cut > 0) || !(sum.far_cut > 0)) continue;
      const Quad x = sum.u / sum.w, y = sum.v / sum.w, nearness = sum.n / sum.w;
      if (!(x > 0 && y > 0 && x < kSide && y < kSide)) continue;
      ++points_;
      ASSERT_FALSE(rects.unseen >> lane & 1U) << "lane " << lane;
      ASSERT_LE(Quad(rects.x0[lane]), x);
      ASSERT_GE(Quad(rects.x1[lane]) + 1, x);
      ASSERT_LE(Quad(rects.y0[lane]), y);
      ASSERT_GE(Quad(rects.y1[lane]) + 1, y);
      ASSERT_GE(Quad(rects.nearest[lane]), nearness);
    }
  }

  std::mt19937_64 random_{3};
  double depth_ = 1.0;
  OccludeeView view_;
  TriangleLanes triangles_{};
  std::size_t points_ = 0, turned_away_ = 0;
};

TEST_F(RectAttack, EveryPointThatIsSeenLiesInItsRectangleAndNoNearer) {
  for (int round = 0; round < 8000 && !HasFatalFailure(); ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    next();
    for (const double front : {-1.0, 0.0, 1.0}) {
      TriangleRects rects;
      projectTriangles(view_, triangles_, front, rects);
      for (std::size_t lane = 0; lane < kTriangleLanes; ++lane) {
        judge(lane, front, rects);
        turned_away_ += rects.unseen >> lane & 1U;
      }
    }
  }
  std::printf("%zu points, %zu unseen\n", points_, turned_away_);
  EXPECT_GT(points_, 50000U);
  EXPECT_GT(turned_away_, 10000U);
}

}  // namespace
}  // namespace culld
