#include "culling/pairs/pairs.h"

#include <gtest/gtest.h>

#include "tests/scenes/known_scenes.h"
#include "tests/scenes/shapes.h"

namespace culld {
namespace {

constexpr double kInf = std::numeric_limits<double>::infinity();

Place at(double x, double y, double z, double radius_m = 0.0) {
  return {{{x, y, z}, {x, y, z}}, radius_m};
}

/// Two rooms of boxes: a wall at z = 0, ten metres wide and high, half a metre thick.
SnapshotPtr wall(scenes::Alpha alpha = scenes::Alpha::kOpaque, bool double_sided = false) {
  scenes::Model model;
  scenes::Material material;
  material.alpha = alpha;
  material.double_sided = double_sided;
  const auto number = model.addMaterial(material);
  const auto mesh =
      model.addMesh({"wall", {{scenes::box({-5, 0, -0.25F}, {5, 10, 0.25F}), number}}});
  scenes::ModelNode node;
  node.mesh = mesh;
  model.addNode(node);
  return scenes::toSnapshot(model);
}

bool maySee(const PairsAnswer& answer, std::size_t bit) {
  return (answer.may_see.at(bit / 8) >> bit % 8 & 1U) != 0;
}

TEST(Pairs, AreBitsByViewerThenTarget) {
  const PairsCuller culler(*wall());
  EXPECT_EQ(culler.blockers(), 1U);
  EXPECT_GT(culler.bytes(), 100U);
  const Place viewers[] = {at(0, 2, 5), at(0, 2, -5), at(0, 60, 5)};
  const Place targets[] = {at(0, 2, -3), at(1, 2, 3), at(-1, 1, -4)};
  const auto answer = culler.cull(viewers, targets);
  ASSERT_TRUE(answer.ok());
  const bool expected[] = {false, true, false, true, false, true, true, true, true};
  for (std::size_t i = 0; i < 9; ++i) EXPECT_EQ(maySee(answer.value(), i), expected[i]) << i;
  EXPECT_EQ(answer.value().may_see.size(), 2U);
  EXPECT_EQ(answer.value().may_see[1] & 0xFEU, 0U) << "bits beyond the last pair";
  EXPECT_EQ(answer.value().hidden, 3U);
}

TEST(Pairs, HoldForAllOfBoxesAndMotion) {
  const PairsCuller culler(*wall());
  const auto hidden = [&](const Place& viewer, const Place& target) {
    return culler.cull({&viewer, 1}, {&target, 1}).value().hidden == 1;
  };
  EXPECT_TRUE(hidden(at(0, 5, 5), at(0, 5, -5)));
  EXPECT_TRUE(hidden(at(0, 5, 5, 2), at(0, 5, -5, 2)));
  EXPECT_FALSE(hidden(at(0, 5, 5, 2), at(0, 5, -10, 9))) << "around the wall";
  EXPECT_FALSE(hidden(at(0, 5, 5, 4.8), at(0, 5, -5))) << "into the wall";
  EXPECT_TRUE(hidden(at(0, 5, 5), {{{-4, 1, -2}, {4, 9, -1}}, 0.0}));
  EXPECT_FALSE(hidden(at(0, 5, 5), {{{-7, 1, -2}, {4, 9, -1}}, 0.0}));
}

TEST(Pairs, AreHiddenByOpaqueSolidsOnly) {
  const Place viewer = at(0, 2, 5), target = at(0, 2, -5);
  for (const auto& scene : {wall(scenes::Alpha::kMask), wall(scenes::Alpha::kBlend),
                            std::make_shared<const SceneSnapshot>()}) {
    const PairsCuller culler(*scene);
    EXPECT_EQ(culler.blockers(), 0U);
    EXPECT_EQ(culler.cull({&viewer, 1}, {&target, 1}).value().hidden, 0U);
  }
}

TEST(Pairs, AreHiddenByFacesOfWhatIsNotConvex) {
  // A box and a fin that share a corner: no convex parts alone, and double-sided besides.
  scenes::Model model;
  scenes::Material both_sides;
  both_sides.double_sided = true;
  const auto material = model.addMaterial(both_sides);
  scenes::Triangles shape = scenes::box({-5, 0, -0.25F}, {5, 10, 0.25F});
  scenes::append(shape, scenes::quad({-5, 0, -0.25F}, {0, 0, -9}, {0, 10, 0}));
  const auto mesh = model.addMesh({"corner", {{shape, material}}});
  scenes::ModelNode node;
  node.mesh = mesh;
  model.addNode(node);
  const PairsCuller culler(*scenes::toSnapshot(model));
  EXPECT_EQ(culler.blockers(), 14U) << "seven faces, from both sides";
  const auto hidden = [&](const Place& viewer, const Place& target) {
    return culler.cull({&viewer, 1}, {&target, 1}).value().hidden == 1;
  };
  EXPECT_TRUE(hidden(at(0, 5, 5), at(0, 5, -5, 1)));
  EXPECT_TRUE(hidden(at(0, 5, -5), at(0, 5, 5, 1)));
  EXPECT_TRUE(hidden(at(0, 5, 0), at(0, 5, 5, 1))) << "from inside: its other side blocks";
  EXPECT_TRUE(hidden(at(-9, 5, -5), at(0, 5, -5, 1)));
  EXPECT_FALSE(hidden(at(0, 5, 5), at(9, 5, -5, 1)));
}

TEST(Pairs, OfNobodyAreNone) {
  const PairsCuller culler(*wall());
  const Place place = at(0, 2, 5);
  EXPECT_TRUE(culler.cull({}, {&place, 1}).value().may_see.empty());
  EXPECT_TRUE(culler.cull({&place, 1}, {}).value().may_see.empty());
}

TEST(Pairs, NameThePlaceThatIsNone) {
  const PairsCuller culler(*wall());
  const Place good = at(0, 2, 5);
  const auto viewerError = [&](const Place& bad) {
    const Place viewers[] = {good, bad};
    return culler.cull(viewers, {&good, 1}).error().message;
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(viewerError(at(nan, 0, 0)), "viewer 1: an empty box");
  EXPECT_EQ(viewerError({{{1, 0, 0}, {0, 1, 1}}, 0.0}), "viewer 1: an empty box");
  EXPECT_EQ(viewerError(at(kInf, 0, 0)), "viewer 1: farther out than 1e90 m");
  EXPECT_EQ(viewerError(at(1e91, 0, 0)), "viewer 1: farther out than 1e90 m");
  for (const double radius : {nan, -1.0, kInf}) {
    EXPECT_EQ(viewerError(at(0, 0, 0, radius)),
              "viewer 1: the radius is not a number from 0 to 1e90 m");
  }
  const Place bad = at(nan, 0, 0);
  EXPECT_EQ(culler.cull({&good, 1}, {&bad, 1}).error().message, "target 0: an empty box");
}

/// Goes on by a microsecond each time it is read.
class HastyClock final : public Clock {
 public:
  std::chrono::nanoseconds now() const noexcept override {
    return std::chrono::microseconds(++reads_);
  }

 private:
  mutable std::int64_t reads_ = 0;
};

TEST(Pairs, AreKeptWhenTimeRunsOut) {
  const PairsCuller culler(*wall());
  const std::vector<Place> viewers(200, at(0, 2, 5)), targets(200, at(0, 2, -5));
  const HastyClock clock;
  const auto cut = culler.cull(viewers, targets, std::chrono::microseconds(5), clock).value();
  EXPECT_TRUE(cut.out_of_budget);
  EXPECT_GT(cut.hidden, 0U);
  EXPECT_LT(cut.hidden, 40'000U);
  EXPECT_TRUE(maySee(cut, 39'999));
  const auto whole = culler.cull(viewers, targets).value();
  EXPECT_FALSE(whole.out_of_budget);
  EXPECT_EQ(whole.hidden, 40'000U);
}

}  // namespace
}  // namespace culld
