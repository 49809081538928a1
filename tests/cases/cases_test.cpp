// Every family of stiff and extreme cases, every method, every SIMD target: nothing that can be
// seen is missing, nothing crashes, nothing goes on forever. The curves of docs/stability.md go
// further.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>

#include "tests/cases/case.h"
#include "tests/cases/curve_files.h"
#include "tests/cases/runner.h"
#include "tests/scenes/rounds.h"

namespace culld::cases {
namespace {

constexpr std::uint64_t kSeeds = scenes::rounds(3);

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

std::string contentOf(const std::filesystem::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

TEST(CurveFiles, HoldOneRowPerStepAndMethodAndOnePicturePerFamily) {
  const Family& family = *findFamily("planet");
  Curve curve{&family, {}};
  for (const double value : {0.0, 6.4e6}) {
    CurveStep step{value, runCase(makeCase(family, value, 0)), {}, {}};
    step.slack_ulps.assign(step.run.methods.size(), 3.0);
    step.turned_slack_ulps.assign(step.run.methods.size(), kNoSlack);
    curve.steps.push_back(std::move(step));
  }
  const std::string folder = testing::TempDir() + "/culld_curves";
  std::filesystem::create_directories(folder);
  ASSERT_TRUE(writeCurves(std::vector<Curve>{curve}, folder).ok());
  const std::string csv = contentOf(folder + "/curves.csv");
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')),
            1 + 2 * methodNames().size());
  EXPECT_NE(csv.find("planet,distance of everything from the world's origin,m,6400000,raster,1,"),
            csv.npos)
      << csv;
  EXPECT_NE(contentOf(folder + "/curves.md").find("### planet\n"), csv.npos);
  const std::string picture = contentOf(folder + "/planet.svg");
  EXPECT_TRUE(picture.starts_with("<svg xmlns=") && picture.ends_with("</svg>\n"));
  EXPECT_EQ(picture.find("nan"), picture.npos);
  EXPECT_FALSE(writeCurves(std::vector<Curve>{curve}, folder + "/none").ok());
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace culld::cases
