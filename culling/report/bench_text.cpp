#include <cstdio>

#include "culling/report/bench_summary.h"
#include "culling/report/svg.h"

namespace culld {
namespace {

std::string column(const std::string& text, int width) {
  // Thin spaces take three bytes and one place.
  std::size_t places = 0;
  for (const char c : text) places += (static_cast<unsigned char>(c) & 0xC0U) != 0x80U ? 1 : 0;
  const auto wanted = static_cast<std::size_t>(width < 0 ? -width : width);
  const std::string padding(wanted > places ? wanted - places : 0, ' ');
  return width < 0 ? text + padding + " " : padding + text + " ";
}

std::string rowOf(const SceneFigures& scene, const BenchRun& run) {
  using report::shortNumber;
  const report::RunSummary sum = report::summaryOf(scene, run);
  const auto number = [](const std::optional<double>& v) { return v ? shortNumber(*v) : "-"; };
  return column(scene.methods[run.method].name, -20) +
         column(scene.settings[run.setting].name(), -24) +
         column(std::to_string(sum.missed) + " + " + std::to_string(sum.missed_subpixel), 12) +
         column(shortNumber(sum.visible), 9) + column(shortNumber(sum.answered), 9) +
         column(number(sum.excess), 7) + column(shortNumber(1e-3 * sum.low_us), 9) +
         column(shortNumber(1e-3 * sum.mean_us), 9) + column(shortNumber(1e-3 * sum.high_us), 9) +
         column(number(sum.relative_min), 9) + "\n";
}

}  // namespace

std::string benchText(const BenchReport& report) {
  std::string text;
  for (const SceneFigures& scene : report.scenes) {
    text += "\n" + scene.name + ": " + std::to_string(scene.objects) + " objects, " +
            std::to_string(scene.triangles) + " triangles, " +
            std::to_string(scene.truths.front().size()) + " cameras\n";
    text += column("method", -20) + column("setting", -24) + column("missed", 12) +
            column("visible", 9) + column("answered", 9) + column("excess", 7) +
            column("ms least", 9) + column("median", 9) + column("95 %", 9) +
            column("x frustum", 9) + "\n";
    for (const BenchRun& run : scene.runs) text += rowOf(scene, run);
  }
  return text;
}

}  // namespace culld
