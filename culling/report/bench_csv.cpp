#include "culling/report/bench_summary.h"

#include <cmath>
#include <cstdio>

namespace culld {
namespace {

using report::RunSummary;

/// One row, field by field.
class Row {
 public:
  Row& text(const std::string& value) {
    std::string quoted;
    for (const char c : value) {
      if (c == '"') quoted += '"';
      quoted += c == '\n' || c == '\r' ? ' ' : c;
    }
    return add('"' + quoted + '"');
  }
  Row& number(double value) {
    char digits[40];
    std::snprintf(digits, sizeof digits, "%.9g", value);
    return add(std::isfinite(value) ? digits : "");
  }
  Row& number(const std::optional<double>& value) { return value ? number(*value) : add(""); }
  Row& count(std::uint64_t value) { return add(std::to_string(value)); }
  std::string line() const { return line_ + '\n'; }

 private:
  Row& add(const std::string& field) {
    if (!line_.empty()) line_ += ',';
    line_ += field;
    return *this;
  }
  std::string line_;
};

constexpr const char* kHead =
    "scene,method,made_by,guarantee,width_px,height_px,limit_us,cameras,repetitions,breaches,"
    "missed,missed_subpixel,missed_px,in_frustum,visible,answered,excess,culled_share,"
    "prepare_ms,prepared_bytes,view_bytes,answer_bytes,change_bytes,"
    "time_us_low,time_us_mean,time_us_high,camera_us_min,camera_us_median,camera_us_p95,"
    "camera_us_max,relative_time,relative_time_min,work_us,relative_work,out_of_budget,left_out_by_"
    "frustum,"
    "left_out_by_occlusion,occlusion_extra_us,nodes_visited,tested,plane_tests,"
    "depth_comparisons,occluders_drawn,"
    "triangles_drawn,lossy,said_px,lossy_missed_px,exceeded\n";

std::string rowOf(const SceneFigures& scene, const BenchRun& run) {
  const MethodFigures& method = scene.methods[run.method];
  const BenchSetting& setting = scene.settings[run.setting];
  const RunSummary sum = report::summaryOf(scene, run);
  Row row;
  row.text(scene.name).text(method.name).text(sum.made_by);
  row.text(std::string(guaranteeName(method.guarantee)));
  row.count(setting.image ? setting.image->width_px : 0);
  row.count(setting.image ? setting.image->height_px : 0);
  row.number(std::chrono::duration<double, std::micro>(setting.time).count());
  row.count(run.cameras.size()).count(scene.repeat).count(run.breaches);
  row.count(sum.missed).count(sum.missed_subpixel).number(sum.missed_px);
  row.number(sum.in_frustum).number(sum.visible).number(sum.answered);
  row.number(sum.excess).number(sum.culled_share);
  row.number(method.prepare_ms).count(method.prepared_bytes).count(run.view_bytes);
  row.number(sum.answer_bytes).number(sum.change_bytes);
  row.number(sum.low_us).number(sum.mean_us).number(sum.high_us);
  row.number(sum.cameras_us.min).number(sum.cameras_us.median);
  row.number(sum.cameras_us.p95).number(sum.cameras_us.max);
  row.number(sum.relative).number(sum.relative_min);
  row.number(sum.work_us).number(sum.relative_work).number(sum.out_of_budget);
  row.number(sum.outside).number(sum.occluded).number(sum.extra_us);
  row.number(sum.nodes_visited)
      .number(sum.tested)
      .number(sum.plane_tests)
      .number(sum.depth_comparisons);
  row.number(sum.occluders_drawn).number(sum.triangles_drawn);
  row.count(sum.lossy).number(sum.said_px).number(sum.lossy_missed_px).count(sum.exceeded);
  return row.line();
}

}  // namespace

std::string benchCsv(const BenchReport& report) {
  std::string text = "# " + report.verdict() + '\n' + kHead;
  for (const SceneFigures& scene : report.scenes) {
    for (const BenchRun& run : scene.runs) text += rowOf(scene, run);
  }
  return text;
}

}  // namespace culld
