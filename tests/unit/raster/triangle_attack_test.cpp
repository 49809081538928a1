// Attacks docs/error-model.md §4: triangles whose true vertices lie anywhere within the stated
// errors, on and within ulps of cell corners, behind the eye, as slivers; judged in 113-bit
// arithmetic.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <vector>

#include "culling/raster/cell_view.h"
#include "culling/raster/triangle_blocks.h"

namespace culld {
namespace {

__extension__ typedef __float128 Quad;

constexpr std::uint32_t kBlocks = 6;
constexpr GridSize kGrid{8.0 * kBlocks, 8.0 * kBlocks};

struct TrueVertex {
  Quad u, v, w, n, near_cut, far_cut;
};

struct Point {  // of the true triangle, on the image
  Quad u, v, nearness;
  bool between_clip_planes;
};

class Attack {
 public:
  explicit Attack(std::uint64_t seed) : random_(seed) {}

  double real(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  bool chance(int one_in) { return random_() % static_cast<std::uint64_t>(one_in) == 0; }

  double coordinate() {
    double x = real(-10.0, kGrid.width + 10.0);
    if (chance(2)) x = std::round(x);  // on a cell's rim, then off it by ulps
    for (std::uint64_t i = random_() % 4; i > 0; --i) x = std::nextafter(x, chance(2) ? 1e9 : -1e9);
    if (chance(12)) x *= 1e6;
    return x;
  }

  void next() {
    const double relative = chance(3) ? 1e-4 : chance(2) ? 1e-9 : 0x1p-48;
    const double depth = std::exp2(real(-6.0, 12.0));
    std::array<CellVertex*, 3> vertex{&p, &q, &r};
    double mu = 0, mv = 0, mw = 0;
    for (CellVertex* x : vertex) {
      const double w = depth * (chance(4) ? real(-1.0, 1.0) : real(0.5, 2.0));
      *x = {coordinate() * w, coordinate() * w, w, 1.0, w - 0.3 * depth, 1.6 * depth - w};
      if (chance(8)) x->u = vertex[0]->u * (w / vertex[0]->w);  // slivers
      mu = std::max(mu, std::abs(x->u));
      mv = std::max(mv, std::abs(x->v));
      mw = std::max(mw, std::abs(x->w));
    }
    error = {relative * mu, relative * mv, relative * mw, 0.0, relative * mw, relative * mw};
    if (chance(3)) makeOrthographic(relative);
    for (std::size_t i = 0; i < 3; ++i) {
      const CellVertex& x = *vertex[i];
      truth[i] = {moved(x.u, error.u),
                  moved(x.v, error.v),
                  moved(x.w, error.w),
                  moved(x.n, error.n),
                  moved(x.near_cut, error.near_cut),
                  moved(x.far_cut, error.far_cut)};
    }
  }

  /// A random point of the true triangle; corners and edges often. False if it is behind the eye.
  bool point(Point& out, int edge) {
    Quad weight[3];
    Quad total = 0;
    for (int i = 0; i < 3; ++i) {
      weight[i] = chance(5) ? 0.0 : real(0.0, 1.0);
      if (edge >= 0 && i == (edge + 2) % 3) weight[i] = 0;
      total += weight[i];
    }
    if (!(total > 0)) return false;
    Quad u = 0, v = 0, w = 0, n = 0, near_cut = 0, far_cut = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      u += weight[i] * truth[i].u;
      v += weight[i] * truth[i].v;
      w += weight[i] * truth[i].w;
      n += weight[i] * truth[i].n;
      near_cut += weight[i] * truth[i].near_cut;
      far_cut += weight[i] * truth[i].far_cut;
    }
    if (!(w > 0)) return false;
    out = {u / w, v / w, n / w, near_cut >= 0 && far_cut >= 0};
    return out.u >= 0 && out.v >= 0 && out.u < kGrid.width && out.v < kGrid.height;
  }

  /// The true determinant's sign and whether the true triangle, cut at the clip planes, holds (u,
  /// v).
  bool holds(Quad u, Quad v) const {
    Quad near_cut = 0, far_cut = 0;
    const Quad det = determinant();
    for (std::size_t i = 0; i < 3; ++i) {
      const TrueVertex &a = truth[(i + 1) % 3], &b = truth[(i + 2) % 3];
      const Quad e =
          (a.v * b.w - a.w * b.v) * u + (a.w * b.u - a.u * b.w) * v + (a.u * b.v - a.v * b.u);
      const Quad barycentric = e / det;
      if (barycentric < 0) return false;
      near_cut += barycentric * truth[i].near_cut;
      far_cut += barycentric * truth[i].far_cut;
    }
    return near_cut >= 0 && far_cut >= 0;
  }

  Quad determinant() const {
    const TrueVertex &a = truth[0], &b = truth[1], &c = truth[2];
    return a.u * (b.v * c.w - b.w * c.v) + a.v * (b.w * c.u - b.u * c.w) +
           a.w * (b.u * c.v - b.v * c.u);
  }

  CellVertex p{}, q{}, r{};
  CellVertexError error;
  std::array<TrueVertex, 3> truth{};

 private:
  /// w is 1 exactly; nearness is a coordinate like the others, with an error of its own.
  void makeOrthographic(double relative) {
    double mu = 0, mv = 0;
    const bool facing = chance(2);  // all at one depth
    const double depth = real(-0.2, 1.2);
    for (CellVertex* x : {&p, &q, &r}) {
      const double n = facing ? depth : real(-0.2, 1.2);
      *x = {x->u / x->w, x->v / x->w, 1.0, n, 1.0 - n, n};
      mu = std::max(mu, std::abs(x->u));
      mv = std::max(mv, std::abs(x->v));
    }
    error = {relative * mu, relative * mv, 0.0, relative, relative, relative};
  }

  Quad moved(double x, double by) {
    const int choice = static_cast<int>(random_() % 4);
    if (choice == 0) return Quad(x) + Quad(by);
    if (choice == 1) return Quad(x) - Quad(by);
    return Quad(x) + Quad(by) * Quad(real(-1.0, 1.0));
  }

  std::mt19937_64 random_;
};

struct Drawn {
  SheetBlock sheet;
  std::uint64_t filled = 0;  ///< cells that the triangle fills alone
};

constexpr float kUntouched = -3.0e38F;  // below every nearness

/// As the sheet rasterizer goes through the blocks.
std::map<std::uint32_t, Drawn> drawBlocks(const ProjectedTriangle& t, std::uint32_t net_edges) {
  std::map<std::uint32_t, Drawn> blocks;
  if (!t.on_grid) return blocks;
  const TriangleBlocks triangle_blocks(t, net_edges);
  BlockTriangle part;
  for (std::uint32_t y = t.cell_y0 / 8; y <= t.cell_y1 / 8; ++y) {
    const BlockSpan span = triangle_blocks.span(y);
    for (std::uint32_t x = span.first_touched; x < span.end_touched; ++x) {
      Drawn drawn;
      drawn.sheet.clear();
      if (x >= span.first_filled && x < span.end_filled) {
        drawn.filled = drawn.sheet.sampled = ~std::uint64_t{0};
        drawn.sheet.farthest.fill(triangle_blocks.farthest(x, y));
      } else if (triangle_blocks.part(x, y, part)) {
        std::array<float, 64> nearness;
        nearness.fill(kUntouched);
        addTriangle(part, drawn.sheet, nearness.data());
        for (std::size_t cell = 0; cell < 64; ++cell) {
          if (nearness[cell] != kUntouched) drawn.filled |= std::uint64_t{1} << cell;
        }
      } else {
        continue;
      }
      blocks[y * kBlocks + x] = drawn;
    }
  }
  return blocks;
}

struct CellRef {
  std::uint32_t block, cell;
};

CellRef cellOf(const Point& point) {
  const auto u = static_cast<std::uint32_t>(point.u);
  const auto v = static_cast<std::uint32_t>(point.v);
  return {v / 8 * kBlocks + u / 8, v % 8 * 8 + u % 8};
}

int orientation(const CellVertex& p, const CellVertex& q, const CellVertex& r,
                const CellVertexError& error) {
  return orientTriangle(p, q, r, error, kGrid, 0).orientation;
}

TEST(TriangleAttack, CertainOrientationIsTheTrueOne) {
  Attack attack(1);
  int certain = 0;
  for (int round = 0; round < 30000; ++round) {
    attack.next();
    const int sign = orientation(attack.p, attack.q, attack.r, attack.error);
    for (const int wanted : {-1, 1}) {
      const auto asked = orientTriangle(attack.p, attack.q, attack.r, attack.error, kGrid, wanted);
      ASSERT_EQ(asked.orientation, sign == wanted ? wanted : 0) << "round " << round;
    }
    if (sign == 0) continue;
    ++certain;
    ASSERT_GT(attack.determinant() * Quad(sign), Quad(0)) << "round " << round;
  }
  EXPECT_GT(certain, 20000);
}

TEST(TriangleAttack, EveryPointOfTheTriangleIsTouchedAndNoNearerThanStored) {
  Attack attack(2);
  int points = 0;
  for (int round = 0; round < 60000; ++round) {
    attack.next();
    const OrientedTriangle oriented =
        orientTriangle(attack.p, attack.q, attack.r, attack.error, kGrid, 0);
    if (oriented.orientation == 0) continue;
    const auto t = projectTriangle(attack.p, attack.q, attack.r, attack.error, kGrid, oriented);
    const auto blocks = drawBlocks(t, 7);
    for (int k = 0; k < 12; ++k) {
      Point point{};
      const int edge = k < 6 ? k % 3 : -1;
      if (!attack.point(point, edge) || !point.between_clip_planes) continue;
      ++points;
      const CellRef at = cellOf(point);
      const auto block = blocks.find(at.block);
      ASSERT_NE(block, blocks.end()) << "round " << round;
      const float farthest = block->second.sheet.farthest[at.cell];
      ASSERT_LE(Quad(farthest), point.nearness) << "round " << round;
      if (edge >= 0) {
        ASSERT_TRUE(block->second.sheet.rim >> at.cell & 1U) << "round " << round;
        ASSERT_FALSE(block->second.filled >> at.cell & 1U) << "round " << round;
      }
    }
  }
  EXPECT_GT(points, 20000);
}

TEST(TriangleAttack, FilledCellsAndSampledPointsAreInsideTheTriangle) {
  Attack attack(3);
  int filled = 0, sampled = 0;
  for (int round = 0; round < 3000; ++round) {
    attack.next();
    const OrientedTriangle oriented =
        orientTriangle(attack.p, attack.q, attack.r, attack.error, kGrid, 0);
    if (oriented.orientation == 0) continue;
    const auto t = projectTriangle(attack.p, attack.q, attack.r, attack.error, kGrid, oriented);
    for (const auto& [index, drawn] : drawBlocks(t, 0)) {
      for (std::uint32_t cell = 0; cell < 64; ++cell) {
        const std::uint32_t column = index % kBlocks * 8 + cell % 8;
        const std::uint32_t row = index / kBlocks * 8 + cell / 8;
        const Quad u = column, v = row;
        if (drawn.filled >> cell & 1U) {
          ++filled;
          ASSERT_TRUE(attack.holds(u, v) && attack.holds(u + 1, v) && attack.holds(u, v + 1) &&
                      attack.holds(u + 1, v + 1))
              << "round " << round;
        }
        if (drawn.sheet.sampled >> cell & 1U) {
          ++sampled;
          ASSERT_TRUE(attack.holds(u + Quad(kSampleX), v + Quad(kSampleY))) << "round " << round;
        }
      }
    }
  }
  EXPECT_GT(filled, 50000);
  EXPECT_GT(sampled, 50000);
}

TEST(TriangleAttack, NumbersOutOfRangeAreNotUsed) {
  const CellVertexError error{1e-9, 1e-9, 1e-9, 0, 1e-9, 1e-9};
  const CellVertex p{0, 0, 1, 1, 1, 1}, q{40, 0, 1, 1, 1, 1};
  for (double bad : {std::nan(""), 1e300, -1e300, HUGE_VAL}) {
    EXPECT_EQ(orientation(p, q, {bad, 40, 1, 1, 1, 1}, error), 0);
    EXPECT_EQ(orientation(p, q, {10, 40, bad, 1, 1, 1}, error), 0);
    EXPECT_EQ(orientation(p, q, {10, 40, 1, 1, bad, 1}, error), 0);
  }
  EXPECT_EQ(orientation(p, q, {10, 40, 1, 1, 1, 1}, error), 1);
  EXPECT_EQ(orientation(q, p, {10, 40, 1, 1, 1, 1}, error), -1);
}

}  // namespace
}  // namespace culld
