// Writes the curves of docs/stability.md: per family of stiff and extreme cases, the quantity that
// is pushed against what was missed, the excess, the time and the depth slack.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/cases/case.h"
#include "tests/cases/curve_files.h"
#include "tests/cases/runner.h"

namespace culld::cases {
namespace {

struct Wanted {
  std::vector<std::string> families;
  std::uint64_t seeds = 5;
  std::string folder;
  RunOptions run;
};

void measureSlack(const Family& family, std::uint64_t seeds, CurveStep& step) {
  const bool measurable = makeProbe(family, step.value, 0, 0.0).has_value();
  for (const MethodRun& run : step.run.methods) {
    double straight = kNoSlack, worst = kNoSlack;
    if (measurable) {
      straight = depthSlackUlps(family, step.value, 0, run.method);
      for (std::uint64_t seed = 1; seed < seeds; ++seed) {
        const double slack = depthSlackUlps(family, step.value, seed, run.method);
        if (!(slack <= worst)) worst = slack;
      }
    }
    step.slack_ulps.push_back(straight);
    step.turned_slack_ulps.push_back(worst);
  }
}

Curve curveOf(const Family& family, const Wanted& wanted) {
  Curve curve{&family, {}};
  for (const double value : family.steps) {
    CurveStep step;
    step.value = value;
    const bool heavy = value > family.quick_up_to;
    for (std::uint64_t seed = 0; seed < (heavy ? 1 : wanted.seeds); ++seed) {
      RunOptions options = wanted.run;
      if (heavy) options.rays_per_object = 4;
      step.run.add(runCase(makeCase(family, value, seed), options));
    }
    measureSlack(family, wanted.seeds, step);
    for (const std::string& fault : step.run.faults) {
      std::fprintf(stderr, "stability_curves: %s at %g: %s\n", std::string(family.name).c_str(),
                   value, fault.c_str());
    }
    curve.steps.push_back(std::move(step));
  }
  return curve;
}

/// True if no promise was broken.
bool run(const Wanted& wanted) {
  std::vector<Curve> curves;
  bool kept = true;
  for (const Family& family : families()) {
    const auto& names = wanted.families;
    if (!names.empty() && std::find(names.begin(), names.end(), family.name) == names.end())
      continue;
    curves.push_back(curveOf(family, wanted));
    for (const CurveStep& step : curves.back().steps) kept = kept && step.run.faults.empty();
    std::printf("%s\n", std::string(family.name).c_str());
    std::fflush(stdout);
  }
  std::filesystem::create_directories(wanted.folder);
  if (auto written = writeCurves(curves, wanted.folder); !written) {
    std::fprintf(stderr, "stability_curves: %s\n", written.error().message.c_str());
    return false;
  }
  return kept;
}

}  // namespace
}  // namespace culld::cases

int main(int argc, char** argv) try {
  culld::cases::Wanted wanted;
  wanted.run.repeats = 5;
  CLI::App app(
      "Pushes every method through the stiff and extreme cases; exit 1 if one broke its promise.",
      "stability_curves");
  app.add_option("-o,--out", wanted.folder, "folder for curves.csv, curves.md and the pictures")
      ->required();
  app.add_option("--family", wanted.families, "only these")->check([](const std::string& name) {
    return culld::cases::findFamily(name) != nullptr ? "" : "no such family: " + name;
  });
  app.add_option("--seeds", wanted.seeds, "cases per step")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  app.add_option("--samples", wanted.run.samples, "oracle samples per camera")
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  return culld::cases::run(wanted) ? 0 : 1;
} catch (const std::exception& failure) {
  std::fprintf(stderr, "stability_curves: %s\n", failure.what());
  return 2;
}
