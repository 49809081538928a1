#include "culling/report/bench_plots.h"

#include <algorithm>
#include <array>
#include <functional>

#include "culling/report/plot.h"

namespace culld::report {
namespace {

// More cameras than this are drawn in groups.
constexpr std::size_t kMaxPathPoints = 220;

double ms(double us) { return us * 1e-3; }

/// "raster at 500 us: 1.2 ms (1.1 to 1.4), excess 1.5, missed 0"
std::string tipOf(const SceneRows& rows, std::size_t i) {
  const BenchRun& run = rows.scene.runs[i];
  const RunSummary& sum = rows.rows[i];
  std::string tip = rows.scene.methods[run.method].name + ", " +
                    rows.scene.settings[run.setting].name() + ": " + shortTime(sum.mean_us) + " (" +
                    shortTime(sum.low_us) + " to " + shortTime(sum.high_us) + ")";
  if (sum.excess) tip += ", excess " + shortNumber(*sum.excess);
  return tip + ", missed " + std::to_string(sum.missed + sum.missed_subpixel);
}

/// What tells a setting from the others of the scene; nothing if there is only one.
std::string labelOf(const SceneFigures& scene, std::size_t setting) {
  const BenchSetting& at = scene.settings[setting];
  std::string label;
  if (scene.settings.size() > scene.limits && at.image) {
    label = std::to_string(at.image->width_px) + "x" + std::to_string(at.image->height_px);
  }
  if (scene.limits == 1 || at.time.count() == 0) return label;
  const auto us = std::chrono::duration<double, std::micro>(at.time).count();
  return label + (label.empty() ? "" : ", ") + "\u2264 " + shortTime(us);
}

using Pick = std::function<std::optional<double>(const RunSummary&)>;

std::vector<PlotSeries> seriesOf(const SceneRows& rows, const Pick& y) {
  std::vector<PlotSeries> series(rows.scene.methods.size());
  for (std::size_t m = 0; m < series.size(); ++m) series[m].style = styleIndex(rows.scene, m);
  for (std::size_t i = 0; i < rows.rows.size(); ++i) {
    const BenchRun& run = rows.scene.runs[i];
    const RunSummary& sum = rows.rows[i];
    const auto value = y(sum);
    if (!value || !(sum.mean_us > 0.0)) continue;
    series[run.method].points.push_back({ms(sum.mean_us), ms(sum.low_us), ms(sum.high_us), *value,
                                         labelOf(rows.scene, run.setting), tipOf(rows, i),
                                         static_cast<bool>(rows.on_front[i])});
  }
  return series;
}

PlotSpec againstTime(std::string y_name) {
  PlotSpec spec;
  spec.x_name = "time per camera (ms)";
  spec.y_name = std::move(y_name);
  return spec;
}

std::string missed(const SceneRows& rows, const char* name, const Pick& pick) {
  PlotSpec spec = againstTime(name);
  spec.y_kind = Axis::Kind::kLogWithZero;
  spec.words = "nothing was missed in any answer";
  std::vector<PlotSeries> series = seriesOf(rows, pick);
  for (PlotSeries& one : series) {
    for (PlotPoint& point : one.points) {
      point.on_front = false;  // of time and excess
      if (point.y > 0.0) spec.words.clear();
      if (!(point.y > 0.0)) point.label.clear();
    }
  }
  return pointPlot(spec, series);
}

using Value = std::function<std::optional<std::array<double, 3>>(const RunSummary&)>;

std::string overview(const std::vector<SceneRows>& scenes, const DotSpec& spec,
                     const Value& value) {
  std::vector<DotRow> rows;
  for (const SceneRows& scene : scenes) {
    DotRow row{scene.scene.name, {}};
    for (std::size_t m = 0; m < scene.scene.methods.size(); ++m) {
      const std::size_t run = scene.unlimited(m);
      const auto at = value(scene.rows[run]);
      if (!at || !((*at)[0] > 0.0)) continue;
      row.dots.push_back(
          {styleIndex(scene.scene, m), (*at)[0], (*at)[1], (*at)[2], tipOf(scene, run)});
    }
    rows.push_back(std::move(row));
  }
  return dotPlot(spec, rows);
}

}  // namespace

SceneRows::SceneRows(const SceneFigures& figures)
    : scene(figures), on_front(figures.runs.size(), false) {
  std::vector<Cost> costs;
  std::vector<std::size_t> of_run;
  for (std::size_t i = 0; i < figures.runs.size(); ++i) {
    rows.push_back(summaryOf(figures, figures.runs[i]));
    if (figures.runs[i].breaches > 0 || !rows.back().excess) continue;
    costs.push_back({rows.back().mean_us, *rows.back().excess});
    of_run.push_back(i);
  }
  for (const std::size_t at : paretoFront(costs)) on_front[of_run[at]] = true;
}

std::size_t styleIndex(const SceneFigures& scene, std::size_t method) {
  return scene.runs[method].made_by.empty() ? scene.methods[method].style : kRingStyle;
}

std::string missedPlot(const SceneRows& rows) {
  return missed(rows, "objects missed, all cameras", [](const RunSummary& sum) {
    return static_cast<double>(sum.missed + sum.missed_subpixel);
  });
}

std::string missedPxPlot(const SceneRows& rows) {
  return missed(rows, "pixels missed, all cameras",
                [](const RunSummary& sum) { return sum.missed_px; });
}

std::string excessPlot(const SceneRows& rows) {
  PlotSpec spec = againstTime("excess: objects answered / visible");
  spec.y_line = 1.0;
  spec.y_line_name = "only what is visible";
  spec.front = true;
  return pointPlot(spec, seriesOf(rows, [](const RunSummary& sum) { return sum.excess; }));
}

std::string pathPlot(const SceneRows& rows) {
  PlotSpec spec;
  spec.x_kind = Axis::Kind::kLinear;
  spec.x_name = "camera, by its number in the file";
  spec.y_name = "time (ms): median, band from least to 95 %";
  std::vector<BandSeries> series;
  for (std::size_t m = 0; m < rows.scene.methods.size(); ++m) {
    const BenchRun& run = rows.scene.runs[rows.unlimited(m)];
    const auto& truths = rows.scene.truthOf(run);
    const std::size_t count = run.cameras.size();
    const std::size_t group = (count + kMaxPathPoints - 1) / kMaxPathPoints;
    BandSeries band{styleIndex(rows.scene, m), {}, {}, {}, {}};
    for (std::size_t first = 0; first < count; first += group) {
      const std::size_t last = std::min(count, first + group);
      std::vector<double> low, middle, high;
      for (std::size_t i = first; i < last; ++i) {
        low.push_back(run.cameras[i].time_us.min);
        middle.push_back(run.cameras[i].time_us.median);
        high.push_back(run.cameras[i].time_us.p95);
      }
      band.x.push_back(static_cast<double>(truths[first].camera));
      band.low.push_back(ms(spreadOf(std::move(low)).min));
      band.middle.push_back(ms(spreadOf(std::move(middle)).median));
      band.high.push_back(ms(spreadOf(std::move(high)).max));
    }
    series.push_back(std::move(band));
  }
  return bandPlot(spec, series);
}

std::string stagesPlot(const SceneRows& rows) {
  std::vector<BarRow> bars;
  for (std::size_t m = 0; m < rows.scene.methods.size(); ++m) {
    const RunSummary& sum = rows.rows[rows.unlimited(m)];
    const double kept = std::max(0.0, sum.answered - sum.visible);
    std::string text = shortNumber(sum.occluded) + " left out";
    if (m != rows.scene.baseline) {
      text += std::string(sum.extra_us < 0.0 ? ", " : ", +") + shortTime(sum.extra_us);
    }
    bars.push_back({rows.scene.methods[m].name,
                    text,
                    {{sum.visible, kVisibleColor, shortNumber(sum.visible) + " visible"},
                     {kept, kKeptColor, shortNumber(kept) + " hidden, answered anyway"},
                     {sum.occluded, kLeftOutColor, shortNumber(sum.occluded) + " left out"}}});
  }
  return barPlot(bars);
}

std::string memoryPlot(const SceneRows& rows) {
  std::vector<BarRow> bars;
  for (std::size_t m = 0; m < rows.scene.methods.size(); ++m) {
    const auto prepared = static_cast<double>(rows.scene.methods[m].prepared_bytes);
    const auto view = static_cast<double>(rows.scene.runs[rows.unlimited(m)].view_bytes);
    bars.push_back({rows.scene.methods[m].name,
                    shortBytes(prepared) + " prepared, " + shortBytes(view) + " a view",
                    {{prepared, kPreparedColor, shortBytes(prepared) + " prepared"},
                     {view, kViewColor, shortBytes(view) + " per view"}}});
  }
  return barPlot(bars);
}

std::string preparePlot(const SceneRows& rows) {
  std::vector<BarRow> bars;
  for (std::size_t m = 0; m < rows.scene.methods.size(); ++m) {
    const MethodFigures& method = rows.scene.methods[m];
    const std::string text = shortTime(1e3 * method.prepare_ms);
    const Style style = styleOf(styleIndex(rows.scene, m));
    bars.push_back({method.name, text, {{method.prepare_ms, style.color, text}}});
  }
  return barPlot(bars);
}

std::string excessOverview(const std::vector<SceneRows>& scenes) {
  return overview(scenes, {"excess: objects answered / visible", 1.0}, [](const RunSummary& sum) {
    using Triple = std::array<double, 3>;
    return sum.excess ? std::optional(Triple{*sum.excess, *sum.excess, *sum.excess}) : std::nullopt;
  });
}

std::string costOverview(const std::vector<SceneRows>& scenes) {
  return overview(scenes, {"time / time of the frustum alone", 1.0}, [](const RunSummary& sum) {
    using Triple = std::array<double, 3>;
    return sum.relative ? std::optional(Triple{*sum.relative, *sum.relative, *sum.relative})
                        : std::nullopt;
  });
}

std::string timeOverview(const std::vector<SceneRows>& scenes) {
  return overview(scenes, {"time per camera (ms), bars from least to 95 %", {}},
                  [](const RunSummary& sum) {
                    using Triple = std::array<double, 3>;
                    return std::optional(Triple{ms(sum.mean_us), ms(sum.low_us), ms(sum.high_us)});
                  });
}

}  // namespace culld::report
