// The bench itself: does it find what is wrong, and only that?
#include "culling/report/bench.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "culling/report/bench_check.h"
#include "culling/report/bench_summary.h"
#include "tests/unit/report/bench_scene.h"

namespace culld::report {
namespace {

using Ids = std::vector<ObjectId>;

class Bench : public testing::Test {
 protected:
  void SetUp() override {
    scene_.name = "half<wall>.glb";
    scene_.scene = halfWall();
    addCamera(7);
    options_.repeat = 3;
    options_.truth.lattice = 1;
    options_.wire_bytes = [](std::span<const ObjectId>, std::span<const ObjectId> now) {
      return 4 * now.size();
    };
  }
  void addCamera(std::size_t number) {
    const auto camera = cameraFromLookAt({}, {320, 180});
    ASSERT_TRUE(camera.ok());
    scene_.cameras.push_back(camera.value());
    scene_.numbers.push_back(number);
  }
  SceneFigures run(const std::vector<const Method*>& methods) {
    scene_.methods.clear();
    for (const Method* method : methods) {
      scene_.methods.push_back({std::string(method->info().name), method, scene_.methods.size()});
    }
    auto figures = benchScene(scene_, options_);
    EXPECT_TRUE(figures.ok()) << (figures ? "" : figures.error().message);
    return std::move(figures).value();
  }
  BenchReport reportOf(const std::vector<const Method*>& methods) {
    return {{{"seed", "1"}}, {run(methods)}};
  }

  BenchScene scene_;
  BenchOptions options_;
  const ScriptedMethod frustum_{"frustum", Guarantee::kConservative, Ids{0, 1, 2, 3}};
  const ScriptedMethod exact_{"exact", Guarantee::kConservative, Ids{0, 2, 3}};
  const ScriptedMethod wrong_{"wrong", Guarantee::kConservative, Ids{0, 1, 3}};
};

TEST_F(Bench, CountsWhatIsAnsweredBesideTheTruth) {
  const SceneFigures figures = run({&frustum_, &exact_});
  ASSERT_EQ(figures.runs.size(), 2U);
  EXPECT_EQ(figures.objects, 5U);
  EXPECT_EQ(figures.truths.at(0).at(0).visible, 3U);
  const RunSummary all = summaryOf(figures, figures.runs[0]);
  const RunSummary exact = summaryOf(figures, figures.runs[1]);
  EXPECT_DOUBLE_EQ(all.excess.value(), 4.0 / 3.0);
  EXPECT_DOUBLE_EQ(all.culled_share.value(), 0.0);
  EXPECT_DOUBLE_EQ(all.outside, 1.0);
  EXPECT_DOUBLE_EQ(exact.excess.value(), 1.0);
  EXPECT_DOUBLE_EQ(exact.culled_share.value(), 1.0);
  EXPECT_DOUBLE_EQ(exact.occluded, 1.0);
  EXPECT_DOUBLE_EQ(exact.answer_bytes, 12.0);
  EXPECT_EQ(figures.methods[1].prepared_bytes, 1234U);
  EXPECT_EQ(exact.missed + exact.missed_subpixel, 0U);
}

TEST_F(Bench, HoldsWhatApproximateAnswersSayAgainstTheTruth) {
  const auto saying = [](float px) {
    return [px](const Camera&, const Demand&) {
      Answer answer;
      answer.visible = {0, 1, 3};  // 2 is visible
      answer.guarantee = Guarantee::kApproximate;
      answer.proven = false;
      answer.missed_px = px;
      return answer;
    };
  };
  const ScriptedMethod humble("humble", Guarantee::kApproximate, saying(1e6F));
  const ScriptedMethod bold("bold", Guarantee::kApproximate, saying(1.0F));
  const BenchReport report = reportOf({&frustum_, &humble, &bold});
  const SceneFigures& figures = report.scenes[0];
  const RunSummary sums[] = {summaryOf(figures, figures.runs[0]),
                             summaryOf(figures, figures.runs[1]),
                             summaryOf(figures, figures.runs[2])};
  EXPECT_EQ(sums[0].lossy, 0U);
  EXPECT_EQ(sums[1].lossy, 1U);
  EXPECT_EQ(sums[1].exceeded, 0U);
  EXPECT_DOUBLE_EQ(sums[1].said_px, 1e6);
  EXPECT_GT(sums[1].lossy_missed_px, 50.0);
  EXPECT_EQ(sums[2].exceeded, 1U);
  EXPECT_NE(benchCsv(report).find(",lossy,said_px,lossy_missed_px,exceeded\n"), std::string::npos);
  EXPECT_NE(benchHtml(report).find(" / 1 of 1"), std::string::npos);
  EXPECT_NE(benchJson(report).find("\"exceeded\":1"), std::string::npos);
}

TEST_F(Bench, FindsThatAVisibleObjectWasLeftOut) {
  const BenchReport report = reportOf({&frustum_, &wrong_});
  const BenchRun& run = report.scenes[0].runs[1];
  EXPECT_EQ(run.breaches, 3U);  // once per repetition
  EXPECT_EQ(run.cameras[0].missed, 1U);
  EXPECT_GT(run.cameras[0].missed_px, 50.0);
  const std::string verdict = report.verdict();
  EXPECT_EQ(
      verdict.rfind("GUARANTEE BROKEN: half<wall>.glb, wrong, no limit, camera 7: object 2 ", 0),
      0U)
      << verdict;
}

TEST_F(Bench, NeitherCountsNorDrawsIdsThatAreNotOfTheScene) {
  const ScriptedMethod beyond("beyond", Guarantee::kConservative, Ids{0, 1, 2, 3, 4'000'000});
  const BenchReport report = reportOf({&frustum_, &beyond});
  const BenchRun& run = report.scenes[0].runs[1];
  EXPECT_EQ(run.breaches, 3U);
  EXPECT_EQ(run.cameras[0].answered, 0.0);
  EXPECT_NE(report.verdict().find("object 4000000 is not in the scene"), std::string::npos);
}

TEST_F(Bench, SaysSoInTheFirstLineOfEveryReport) {
  const BenchReport report = reportOf({&frustum_, &wrong_});
  const std::string csv = benchCsv(report), html = benchHtml(report);
  EXPECT_EQ(csv.substr(0, csv.find('\n')), "# " + report.verdict());
  EXPECT_NE(html.substr(0, html.find('\n')).find("GUARANTEE BROKEN: half&lt;wall&gt;.glb, wrong"),
            std::string::npos);
  const auto json = nlohmann::ordered_json::parse(benchJson(report));
  EXPECT_EQ(json.begin().key(), "verdict");
  EXPECT_EQ(json.begin().value(), report.verdict());
  EXPECT_FALSE(json.at("guarantees_held").get<bool>());
}

TEST_F(Bench, ReportsThePlanesThatWereTestedAndTheDepthsCompared) {
  const ScriptedMethod counts("frustum", Guarantee::kConservative,
                              [](const Camera&, const Demand&) {
                                Answer answer;
                                answer.visible = {0, 1, 2, 3, 4};
                                answer.stats.plane_tests = 4711;
                                answer.stats.depth_comparisons = 815;
                                return answer;
                              });
  const BenchReport report = reportOf({&counts});
  const auto json = nlohmann::json::parse(benchJson(report));
  EXPECT_EQ(json.at("scenes").at(0).at("runs").at(0).at("work").at("plane_tests"), 4711.0);
  EXPECT_EQ(json.at("scenes").at(0).at("runs").at(0).at("work").at("depth_comparisons"), 815.0);
  const std::string csv = benchCsv(report);
  EXPECT_NE(csv.find(",tested,plane_tests,depth_comparisons,"), std::string::npos);
  EXPECT_NE(csv.find(",4711,"), std::string::npos);
}

TEST_F(Bench, NeedsNothingFromElsewhereInItsPage) {
  const std::string html = benchHtml(reportOf({&frustum_, &exact_}));
  EXPECT_EQ(html.find("<script"), std::string::npos);
  EXPECT_EQ(html.find("http://"), std::string::npos);
  EXPECT_EQ(html.find("https://"), std::string::npos);
  EXPECT_EQ(html.find("<link"), std::string::npos);
  EXPECT_EQ(html.find("nan"), std::string::npos);
  EXPECT_NE(html.find("data:image/png;base64,iVBOR"), std::string::npos);
  EXPECT_NE(html.find("guarantees held in all 6 answers"), std::string::npos);
}

TEST_F(Bench, RunsEverySettingAndComparesItWithTheBaselineOfItsImage) {
  options_.images = {{160, 90}, {320, 180}};
  options_.limits = {std::chrono::microseconds(500), std::chrono::nanoseconds(0)};
  const SceneFigures figures = run({&frustum_, &exact_});
  ASSERT_EQ(figures.settings.size(), 4U);
  EXPECT_EQ(figures.settings[0].name(), "160x90, no limit");
  EXPECT_EQ(figures.settings[3].name(), "320x180, 500 us");
  ASSERT_EQ(figures.runs.size(), 8U);
  const BenchRun& last = figures.runs.back();
  EXPECT_EQ(last.setting, 3U);
  EXPECT_EQ(last.method, 1U);
  EXPECT_EQ(&figures.baselineOf(last), &figures.runs[4]);
  EXPECT_EQ(figures.truths.size(), 2U);
}

TEST_F(Bench, TakesMoreCamerasThanItHoldsTruthsOf) {
  for (std::size_t i = 0; i < 70; ++i) addCamera(100 + i);
  options_.repeat = 2;
  options_.truth.rays_per_object = 0;
  const BenchReport report = reportOf({&frustum_, &exact_});
  const SceneFigures& figures = report.scenes[0];
  EXPECT_EQ(figures.truths[0].size(), 71U);
  EXPECT_EQ(figures.truths[0].back().camera, 169U);
  EXPECT_GE(figures.runs[1].cameras.back().time_us.max, figures.runs[1].cameras.back().time_us.min);
  EXPECT_DOUBLE_EQ(figures.runs[1].cameras.back().answered, 3.0);
  EXPECT_EQ(report.verdict(), "guarantees held in all 284 answers");
}

TEST_F(Bench, ReportsScenesInWhichNothingIsVisible) {
  scene_.scene = SceneBuilder().finish();
  const ScriptedMethod none("frustum", Guarantee::kConservative, Ids{});
  const BenchReport report = reportOf({&none});
  const RunSummary sum = summaryOf(report.scenes[0], report.scenes[0].runs[0]);
  EXPECT_FALSE(sum.excess.has_value());
  EXPECT_FALSE(sum.culled_share.has_value());
  const auto json = nlohmann::json::parse(benchJson(report));
  EXPECT_TRUE(json.at("scenes").at(0).at("runs").at(0).at("excess").is_null());
  for (const std::string& text : {benchHtml(report), benchCsv(report), benchText(report)}) {
    EXPECT_EQ(text.find("nan"), std::string::npos);
    EXPECT_EQ(text.find("inf,"), std::string::npos);
  }
}

TEST_F(Bench, GoesOnWithoutAMethodThatCannotBePrepared) {
  ScriptedMethod refuses("square", Guarantee::kConservative, Ids{});
  refuses.fails_to_prepare = true;
  const SceneFigures figures = run({&frustum_, &refuses, &exact_});
  ASSERT_EQ(figures.methods.size(), 2U);
  ASSERT_EQ(figures.refused.size(), 1U);
  EXPECT_EQ(figures.refused[0].name, "square");
  EXPECT_EQ(figures.refused[0].why, "too round");
  EXPECT_EQ(figures.methods[figures.runs[1].method].name, "exact");
}

/// Answers of the weaker classes: what may be missing, and what may not.
class Promise : public Bench {
 protected:
  std::string breachOf(const Answer& answer, Guarantee demanded, float hole_px = 1.0F) {
    const auto oracle = Oracle::build(scene_.scene);
    const auto truth = oracle.value()->look(scene_.cameras[0], options_.truth);
    Demand demand;
    demand.guarantee = demanded;
    demand.hole_px = hole_px;
    return checkAnswer({*oracle.value(), *scene_.scene, scene_.cameras[0], truth.value(),
                        options_.truth, demand},
                       answer)
        .breach;
  }
  static Answer of(Ids ids, Guarantee guarantee) {
    Answer answer;
    answer.visible = std::move(ids);
    answer.guarantee = guarantee;
    return answer;
  }
};

TEST_F(Promise, OfASampledAnswerMayMissWhatIsSmallerThanAPixel) {
  const auto sampled = Guarantee::kSampled;
  EXPECT_EQ(breachOf(of({0, 2}, sampled), sampled), "");
  EXPECT_NE(breachOf(of({0, 3}, sampled), sampled).find("object 2"), std::string::npos);
}

TEST_F(Promise, OfAHoleIsBrokenByObjectsThatFillASquareOfThatSide) {
  const auto hole = Guarantee::kHole;
  EXPECT_NE(breachOf(of({0, 3}, hole), hole, 4.0F).find("square"), std::string::npos);
  EXPECT_EQ(breachOf(of({0, 3}, hole), hole, 60.0F), "");
  EXPECT_NE(breachOf(of({0, 2}, hole), hole, 0.0F), "");  // no hole at all
}

TEST_F(Promise, OfAnApproximateAnswerIsItsBoundIfThatIsProven) {
  const auto approximate = Guarantee::kApproximate;
  Answer answer = of({0, 3}, approximate);
  answer.missed_px = 1.0F;
  EXPECT_NE(breachOf(answer, approximate).find("proven bound"), std::string::npos);
  answer.missed_px = 1e6F;
  EXPECT_EQ(breachOf(answer, approximate), "");
  answer.missed_px = 1.0F;
  answer.proven = false;
  EXPECT_EQ(breachOf(answer, approximate), "");
}

TEST_F(Promise, IsBrokenByAWeakerClassThanDemanded) {
  EXPECT_EQ(breachOf(of({0, 1, 2, 3}, Guarantee::kApproximate), Guarantee::kConservative),
            "the answer is approximate, not conservative");
}

TEST_F(Promise, IsBrokenByAnswersThatAreNoSets) {
  const auto conservative = Guarantee::kConservative;
  EXPECT_NE(breachOf(of({0, 2, 2, 3}, conservative), conservative), "");
  EXPECT_NE(breachOf(of({3, 2, 0}, conservative), conservative), "");
  EXPECT_NE(breachOf(of({0, 2, 3, 99}, conservative), conservative), "");
}

TEST_F(Promise, FindsTheLargestSquareOfAnObject) {
  const auto oracle = Oracle::build(scene_.scene);
  const auto wall = largestSquarePx(*oracle.value(), scene_.cameras[0], 0, 2.0);
  ASSERT_TRUE(wall.ok());
  EXPECT_NEAR(wall.value(), 160.0, 1.0);  // half of the image's width, less than its height
  EXPECT_DOUBLE_EQ(largestSquarePx(*oracle.value(), scene_.cameras[0], 1, 2.0).value(), 0.0);
}

}  // namespace
}  // namespace culld::report
