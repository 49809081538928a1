// The GPU against the scalar truth, bit for bit: cells, every level of the pyramid, verdicts.
#include "culling/gpu/depth_pass.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdio>
#include <random>

#include "culling/gpu/depth_reference.h"
#include "tests/unit/gpu/opened_backend.h"

namespace culld::gpu {
namespace {

class DepthPassTest : public WithBackend {
 protected:
  double random(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }

  /// A polygon that turns left around a place of the grid, with a plane or two over it.
  ConvexOutline outline(const CellGrid& grid) {
    ConvexOutline out;
    const double x = random(-0.2, 1.2) * grid.width, y = random(-0.2, 1.2) * grid.height;
    const double radius = std::exp(random(-1.0, 6.0));
    out.side_count = 3 + static_cast<std::uint32_t>(random(0.0, 9.0));
    for (std::uint32_t s = 0; s < out.side_count; ++s) {
      const double angle = 6.2831853 * s / out.side_count;
      const double a = -std::cos(angle), b = -std::sin(angle);
      const double length = std::abs(a) + std::abs(b);
      out.sides[s] = {a / length, b / length, (radius - a * x - b * y) / length, random(0.0, 1e-3)};
    }
    out.plane_count = static_cast<std::uint32_t>(random(0.0, 4.0));
    for (std::uint32_t p = 0; p < out.plane_count; ++p) {
      out.planes[p] = {random(-1.0, 1.0) * 1e-3, random(-1.0, 1.0) * 1e-3, random(0.0, 2.0), true};
    }
    if (random(0.0, 1.0) < 0.02 && out.plane_count > 0) out.planes[0].c = 1e38;
    out.depth_floor = static_cast<float>(std::exp(random(-100.0, 3.0)));
    const auto side = [](double at, std::uint32_t most) {
      return static_cast<std::uint32_t>(std::clamp(at, 0.0, most - 1.0));
    };
    out.cells = {side(x - radius, grid.width), side(x + radius, grid.width),
                 side(y - radius, grid.height), side(y + radius, grid.height)};
    return out;
  }

  BoxGroup group() {
    BoxGroup boxes;
    for (std::size_t lane = 0; lane < kBoxLanes; ++lane) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const double middle = random(-20.0, 20.0), half = std::exp(random(-9.0, 2.5));
        boxes[axis * kBoxLanes + lane] = static_cast<float>(middle - half);
        boxes[(axis + 3) * kBoxLanes + lane] = static_cast<float>(middle + half);
      }
    }
    return boxes;
  }

  /// Looks down -z with nearness 1 / w, or an orthographic one.
  BoxView view(const CellGrid& grid, bool perspective) {
    BoxView out;
    out.width = static_cast<float>(grid.width);
    out.height = static_cast<float>(grid.height);
    out.perspective = perspective;
    if (perspective) {
      out.u = {out.width, 0.0F, -0.5F * out.width, 0.0F};
      out.v = {0.0F, out.height, -0.5F * out.height, 0.0F};
      out.w = {0.0F, 0.0F, -1.0F, 0.0F};
      out.n = {0.0F, 0.0F, 0.0F, 1.0F};
    } else {
      out.u = {0.02F * out.width, 0.0F, 0.0F, 0.5F * out.width};
      out.v = {0.0F, 0.02F * out.height, 0.0F, 0.5F * out.height};
      out.w = {0.0F, 0.0F, 0.0F, 1.0F};
      out.n = {0.0F, 0.0F, 0.02F, 1.0F};
    }
    if (random(0.0, 1.0) < 0.3) out.beside = static_cast<float>(random(0.01, 1.0));
    return out;
  }

  void compare(const CellGrid& grid, std::uint32_t outlines);

  std::mt19937_64 random_{7};
  std::size_t asked_ = 0, hidden_ = 0, raised_ = 0;
};

void DepthPassTest::compare(const CellGrid& grid, std::uint32_t outlines) {
  OutlineBatch batch;
  for (std::uint32_t i = 0; i < outlines; ++i) batch.add(outline(grid), grid);
  std::vector<BoxGroup> groups(67);
  for (BoxGroup& boxes : groups) boxes = group();
  std::vector<GroupQuery> queries;
  for (std::uint32_t g = 0; g < groups.size(); ++g) {
    const auto at = [&] { return static_cast<float>(random(-15.0, 15.0)); };
    queries.push_back({g, static_cast<std::uint32_t>(random_() & 0xFFU), {at(), at(), at()}, 0});
  }
  const BoxView boxes_view = view(grid, random_() % 4 != 0);
  const auto refine = static_cast<std::uint32_t>(random_() % 4);

  DepthReference reference;
  reference.begin(grid);
  reference.draw(batch);
  reference.buildPyramid();
  std::vector<std::uint32_t> expected;
  reference.test(boxes_view, groups, queries, refine, expected);

  auto lease = backend()->acquire();
  ASSERT_TRUE(lease.ok());
  auto& pass = lease.value().data<DepthPass>();
  ASSERT_TRUE(pass.ready().ok()) << pass.ready().error().message;
  pass.begin(grid);
  pass.draw(batch);
  pass.buildPyramid();
  static std::uint64_t key = 1000;
  const GroupSource source{++key, groups.size(), [&](std::vector<BoxGroup>& out) { out = groups; }};
  std::vector<std::uint32_t> hidden;
  pass.test(boxes_view, source, queries, refine, hidden);
  std::vector<float> pyramid;
  pass.readPyramid(pyramid);
  ASSERT_TRUE(lease.value().check().ok());

  const auto truth = reference.pyramid();
  ASSERT_EQ(pyramid.size(), truth.size());
  for (std::size_t i = 0; i < truth.size(); ++i) {
    const bool same =
        std::bit_cast<std::uint32_t>(pyramid[i]) == std::bit_cast<std::uint32_t>(truth[i]);
    ASSERT_TRUE(same || (std::isnan(pyramid[i]) && std::isnan(truth[i])))
        << "word " << i << ": " << pyramid[i] << " instead of " << truth[i];
    raised_ += truth[i] > 0.0F ? 1U : 0U;
  }
  ASSERT_EQ(hidden.size(), expected.size());
  for (std::size_t w = 0; w < hidden.size(); ++w) {
    EXPECT_EQ(hidden[w], expected[w]) << "word " << w;
    hidden_ += static_cast<std::size_t>(std::popcount(expected[w]));
  }
  asked_ += queries.size() * 4;
}

TEST_F(DepthPassTest, EqualsItsReferenceAtEverySizeOfImage) {
  const std::pair<std::uint32_t, std::uint32_t> sizes[] = {
      {1, 1},   {2, 1},     {1, 7},     {3, 3},     {64, 64},    {65, 63}, {127, 129},
      {257, 1}, {320, 180}, {640, 360}, {853, 479}, {1280, 720}, {1279, 5}};
  for (const auto& [width, height] : sizes) {
    SCOPED_TRACE(std::to_string(width) + "x" + std::to_string(height));
    for (const std::uint32_t outlines : {0U, 1U, 40U, 120U}) {
      compare(gridOf(width, height), outlines);
      if (HasFatalFailure()) return;
    }
  }
  std::printf("%zu boxes asked, %zu hidden, %zu texels covered\n", asked_, hidden_, raised_);
  EXPECT_GT(hidden_, 500U);
  EXPECT_GT(raised_, 10'000U);
}

TEST_F(DepthPassTest, KeepsWhatIsNotFinite) {
  const CellGrid grid = gridOf(64, 64);
  ConvexOutline all;  // everything is covered, very near
  all.side_count = 1;
  all.sides[0] = {1.0, 0.0, 1000.0, 0.0};
  all.depth_floor = 1e30F;
  all.cells = {0, 63, 0, 63};
  OutlineBatch batch;
  batch.add(all, grid);
  const float infinity = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  std::vector<BoxGroup> groups(1);
  for (std::size_t lane = 0; lane < kBoxLanes; ++lane) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      groups[0][axis * kBoxLanes + lane] = axis == 2 ? -11.0F : -1.0F;
      groups[0][(axis + 3) * kBoxLanes + lane] = axis == 2 ? -10.0F : 1.0F;
    }
  }
  groups[0][1] = nan;                       // min x of box 1
  groups[0][3 * kBoxLanes + 2] = infinity;  // max x of box 2
  groups[0][5 * kBoxLanes + 3] = nan;       // max z of box 3
  groups[0][5 * kBoxLanes + 4] = 1.0F;      // box 4 reaches behind the eye
  groups[0][5 * kBoxLanes + 5] = 0.0F;      // box 5 reaches the eye's plane
  groups[0][3 * kBoxLanes + 6] = 1e19F;     // box 6 is too large to compute with
  const GroupQuery query{0, 0xFF, {0.0F, 0.0F, 0.0F}, 0};
  BoxView looking = view(grid, true);
  looking.beside = infinity;
  auto lease = backend()->acquire();
  ASSERT_TRUE(lease.ok());
  auto& pass = lease.value().data<DepthPass>();
  pass.begin(grid);
  pass.draw(batch);
  pass.buildPyramid();
  std::vector<std::uint32_t> hidden;
  pass.test(looking, {1, 1, [&](std::vector<BoxGroup>& out) { out = groups; }}, {&query, 1}, 3,
            hidden);
  ASSERT_TRUE(lease.value().check().ok());
  EXPECT_EQ(hidden[0], 0b1000'0001U);
}

/// Everything inside, near.
ConvexOutline coveringAll(const CellRect& cells) {
  ConvexOutline all;
  all.side_count = 1;
  all.sides[0] = {1.0, 0.0, 1000.0, 0.0};
  all.depth_floor = 0.5F;
  all.cells = cells;
  return all;
}

TEST_F(DepthPassTest, LinesOfZerosCoverNothing) {
  const CellGrid grid = gridOf(64, 64);
  OutlineBatch batch;
  batch.add(coveringAll({0, 63, 0, 63}), grid);
  batch.lines[0] = {};
  auto lease = backend()->acquire();
  ASSERT_TRUE(lease.ok());
  auto& pass = lease.value().data<DepthPass>();
  DepthReference reference;
  reference.begin(grid);
  reference.draw(batch);
  pass.begin(grid);
  pass.draw(batch);
  std::vector<float> cells;
  pass.readPyramid(cells);
  ASSERT_TRUE(lease.value().check().ok());
  for (std::size_t i = 0; i < std::size_t{64} * 64; ++i) {
    ASSERT_EQ(cells[i], 0.0F) << i;
    ASSERT_EQ(reference.pyramid()[i], 0.0F) << i;
  }
}

TEST_F(DepthPassTest, FragmentsOutsideTheRectangleCoverNothing) {
  const CellGrid grid = gridOf(64, 64);
  OutlineBatch batch;
  batch.add(coveringAll({8, 23, 4, 23}), grid);
  auto lease = backend()->acquire();
  ASSERT_TRUE(lease.ok());
  GlTable wrong = lease.value().gl();
  wrong.Viewport = [](int x, int y, int width, int height) {
    realTable().Viewport(x, y, width + width / 2, height + height / 2);
  };
  std::vector<float> cells;
  {
    DepthPass pass(wrong, 1);  // the rectangle becomes [12, 36) x [6, 36)
    pass.begin(grid);
    pass.draw(batch);
    pass.readPyramid(cells);
  }
  ASSERT_TRUE(lease.value().check().ok());
  std::size_t covered = 0;
  for (std::size_t y = 0; y < 64; ++y) {
    for (std::size_t x = 0; x < 64; ++x) {
      if (!(cells[y * 64 + x] > 0.0F)) continue;
      ++covered;
      ASSERT_TRUE(x >= 8 && x < 24 && y >= 4 && y < 24) << x << ", " << y;
    }
  }
  EXPECT_GT(covered, 0U);
}

TEST_F(DepthPassTest, ClearsAfterWhatTheLastFrameWrote) {
  static bool written = false, cleared_too_soon = false;
  written = cleared_too_soon = false;
  auto lease = backend()->acquire();
  ASSERT_TRUE(lease.ok());
  GlTable watched = lease.value().gl();
  watched.DrawArraysInstanced = [](unsigned, int, int, int) { written = true; };
  watched.MemoryBarrier = [](unsigned barriers) {
    constexpr unsigned kBufferUpdate = 0x200;
    if ((barriers & kBufferUpdate) != 0) written = false;
    realTable().MemoryBarrier(barriers);
  };
  watched.ClearNamedBufferSubData = [](unsigned, unsigned, std::ptrdiff_t, std::ptrdiff_t, unsigned,
                                       unsigned, const void*) { cleared_too_soon |= written; };
  OutlineBatch batch;
  batch.add(coveringAll({0, 15, 0, 15}), gridOf(16, 16));
  {
    DepthPass pass(watched, 1);
    for (int frame = 0; frame < 2; ++frame) {
      pass.begin(gridOf(16, 16));
      pass.draw(batch);
    }
  }
  EXPECT_TRUE(lease.value().check().ok());
  EXPECT_FALSE(cleared_too_soon);
}

TEST_F(DepthPassTest, UploadsASceneOnceAndForgetsTheLongestUnused) {
  constexpr std::size_t kContexts = 64;
  auto lease = backend()->acquire();
  ASSERT_TRUE(lease.ok());
  DepthPass pass(lease.value().gl(), kContexts);
  pass.begin(gridOf(16, 16));
  pass.buildPyramid();
  const GroupQuery query{0, 1, {0.0F, 0.0F, 0.0F}, 0};
  std::vector<std::uint32_t> hidden;
  const BoxView looking = view(gridOf(16, 16), true);
  const std::uint64_t before = pass.uploads();
  const auto ask = [&](std::uint64_t key, std::size_t count) {
    pass.test(looking,
              {key, count, [&](std::vector<BoxGroup>& out) { out.assign(count, BoxGroup{}); }},
              {&query, 1}, 0, hidden);
  };
  ask(501, 10);
  ask(502, 10);
  ask(501, 10);
  EXPECT_EQ(pass.uploads(), before + 2);
  const std::size_t share = DepthPass::kResidentBytes / kContexts;
  const std::size_t large = share / sizeof(BoxGroup) / 2;
  ask(503, large);
  ask(504, large);
  EXPECT_LE(pass.residentBytes(), share + 2 * sizeof(BoxGroup));
  ask(501, 10);  // it had to go
  EXPECT_EQ(pass.uploads(), before + 5);
  EXPECT_TRUE(lease.value().check().ok());
}

}  // namespace
}  // namespace culld::gpu
