// Every family of stiff and extreme cases, every method, every SIMD target: nothing that can be
// seen is missing, nothing crashes, nothing goes on forever. The curves of docs/stability.md go
// further.
#include <gtest/gtest.h>

#include <set>

#include "tests/cases/case.h"
#include "tests/cases/runner.h"

namespace culld::cases {
namespace {

constexpr std::uint64_t kSeeds = 3;

class Families : public testing::TestWithParam<std::size_t> {
 protected:
  const Family& family() const { return families()[GetParam()]; }
};

TEST_P(Families, KeepTheirPromiseAtEveryStep) {
  for (const double value : family().steps) {
    if (value > family().quick_up_to) continue;
    for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
      SCOPED_TRACE(std::string(family().quantity) + " " + std::to_string(value) + " seed " +
                   std::to_string(seed));
      const CaseRun run = runCase(makeCase(family(), value, seed));
      for (const std::string& fault : run.faults) ADD_FAILURE() << fault;
      EXPECT_GT(run.looks, 0U);
      EXPECT_EQ(run.methods.size(), methodNames().size());
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, Families, testing::Range(std::size_t{0}, families().size()),
                         [](const auto& of) { return std::string(families()[of.param].name); });

TEST(FamilyTable, HasNamesOfItsOwnAndStepsForEach) {
  std::set<std::string_view> names;
  for (const Family& family : families()) {
    EXPECT_TRUE(names.insert(family.name).second) << family.name;
    EXPECT_EQ(findFamily(family.name), &family);
    EXPECT_GE(family.steps.size(), 5U) << family.name;
    EXPECT_NE(family.make == nullptr, family.sight == nullptr) << family.name;
  }
}

TEST(FamilyTable, GivesTheSameCaseForTheSameSeed) {
  for (const Family& family : families()) {
    const double value = family.steps.front();
    const Case one = makeCase(family, value, 5), again = makeCase(family, value, 5);
    EXPECT_EQ(one.scene->contentHash(), again.scene->contentHash()) << family.name;
    EXPECT_EQ(scenes::toJson(one.cameras), scenes::toJson(again.cameras)) << family.name;
  }
}

TEST(DepthSlack, IsMeasuredWhereAWallHidesAndInfiniteWhereNothingIsHidden) {
  const Family& far = *findFamily("distance");
  const double slack = depthSlackUlps(far, 1.0, 0, "raster");
  EXPECT_GT(slack, 0.0);
  EXPECT_LT(slack, 1e4);
  EXPECT_EQ(depthSlackUlps(far, 1.0, 0, "frustum"), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace culld::cases
