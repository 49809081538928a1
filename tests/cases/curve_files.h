// The curves as files: a table for programs (CSV), one for people (Markdown), a picture per family.
#pragma once
#include <limits>
#include <span>
#include <string>
#include <vector>

#include "culling/core/result.h"
#include "tests/cases/case.h"
#include "tests/cases/runner.h"

namespace culld::cases {

/// The family has no wall to measure it by.
inline constexpr double kNoSlack = -1.0;

struct CurveStep {
  double value = 0.0;
  CaseRun run;  ///< of all seeds
  /// Per method of `run`, or kNoSlack: by seed 0, and the worst of the seeds that are turned.
  std::vector<double> slack_ulps, turned_slack_ulps;
};

struct Curve {
  const Family* family = nullptr;
  std::vector<CurveStep> steps;
};

/// FOLDER/curves.csv, FOLDER/curves.md, FOLDER/NAME.svg. ERROR: kIo naming the file.
Result<void> writeCurves(std::span<const Curve> curves, const std::string& folder);

}  // namespace culld::cases
