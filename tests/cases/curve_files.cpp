#include "tests/cases/curve_files.h"

#include <cmath>
#include <cstdio>
#include <fstream>

#include "tests/cases/curve_picture.h"

namespace culld::cases {
namespace {

std::string shortNumber(double number) {
  if (std::isnan(number)) return "n/a";
  if (std::isinf(number)) return number > 0 ? "infinite" : "-infinite";
  char text[32];
  std::snprintf(text, sizeof text, "%.7g", number);
  return text;
}

/// Three digits: of what is measured.
std::string measured(double number) {
  if (!std::isfinite(number)) return shortNumber(number);
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", number);
  return text;
}

std::string share(std::size_t part, std::size_t whole) {
  return whole == 0 ? "n/a" : measured(static_cast<double>(part) / static_cast<double>(whole));
}

std::string slackText(double slack) {
  if (slack == kNoSlack) return "n/a";
  return std::isinf(slack) ? "never" : measured(slack);
}

std::string csvOf(std::span<const Curve> curves) {
  std::string csv =
      "family,quantity,unit,value,method,looks,objects,visible,ties,answered,missed,excess,"
      "time_us_per_look,triangles_drawn,nodes_visited,always_kept,depth_slack_ulps,turned_depth_"
      "slack_ulps\n";
  for (const Curve& curve : curves) {
    for (const CurveStep& step : curve.steps) {
      for (std::size_t m = 0; m < step.run.methods.size(); ++m) {
        const MethodRun& run = step.run.methods[m];
        const double looks = static_cast<double>(step.run.looks);
        csv += std::string(curve.family->name) + ',' + std::string(curve.family->quantity) + ',' +
               std::string(curve.family->unit) + ',' + shortNumber(step.value) + ',' + run.method;
        for (const std::size_t count : {step.run.looks, step.run.objects, step.run.visible,
                                        step.run.ties, run.answered, run.missed, run.excess}) {
          csv += ',' + std::to_string(count);
        }
        csv += ',' + measured(run.time_us / looks);
        for (const std::uint32_t count :
             {run.work.triangles_drawn, run.work.nodes_visited, run.work.always_kept}) {
          csv += ',' + std::to_string(count);
        }
        csv +=
            ',' + slackText(step.slack_ulps[m]) + ',' + slackText(step.turned_slack_ulps[m]) + '\n';
      }
    }
  }
  return csv;
}

/// One table per family: a row per step, missed of all methods, then each method's own columns.
std::string markdownOf(const Curve& curve) {
  const Family& family = *curve.family;
  std::string text = "### " + std::string(family.name) + "\n\n| " + std::string(family.quantity);
  if (!family.unit.empty()) text += " (" + std::string(family.unit) + ")";
  text += " | seen | missed |";
  const auto& methods = curve.steps.front().run.methods;
  for (const MethodRun& run : methods) text += " " + run.method + " not seen |";
  for (const MethodRun& run : methods) text += " " + run.method + " us |";
  for (const MethodRun& run : methods) text += " " + run.method + " slack |";
  text += "\n|";
  for (std::size_t column = 0; column < 3 + 3 * methods.size(); ++column) text += "---:|";
  for (const CurveStep& step : curve.steps) {
    std::size_t missed = 0;
    for (const MethodRun& run : step.run.methods) missed += run.missed;
    text += "\n| " + shortNumber(step.value) + " | " + std::to_string(step.run.visible) + " | " +
            std::to_string(missed) + " |";
    for (const MethodRun& run : step.run.methods)
      text += " " + share(run.excess, run.answered) + " |";
    for (const MethodRun& run : step.run.methods) {
      text += " " + measured(run.time_us / static_cast<double>(step.run.looks)) + " |";
    }
    for (const double slack : step.slack_ulps) text += " " + slackText(slack) + " |";
  }
  return text + "\n\n";
}

Result<void> write(const std::string& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary);
  file << text;
  file.close();
  if (!file) return Error{ErrorCode::kIo, path + ": cannot be written"};
  return Done{};
}

}  // namespace

Result<void> writeCurves(std::span<const Curve> curves, const std::string& folder) {
  if (auto csv = write(folder + "/curves.csv", csvOf(curves)); !csv) return csv;
  std::string text;
  for (const Curve& curve : curves) {
    text += markdownOf(curve);
    const std::string picture = folder + "/" + std::string(curve.family->name) + ".svg";
    if (auto svg = write(picture, pictureOf(curve)); !svg) return svg;
  }
  return write(folder + "/curves.md", text);
}

}  // namespace culld::cases
