#include "culling/report/bench_summary.h"

#include <algorithm>

namespace culld {

std::string BenchSetting::name() const {
  std::string text;
  if (image) {
    text = std::to_string(image->width_px) + "x" + std::to_string(image->height_px) + ", ";
  }
  if (time.count() == 0) return text + "no limit";
  return text +
         std::to_string(std::chrono::duration_cast<std::chrono::microseconds>(time).count()) +
         " us";
}

std::string Breach::line() const {
  return scene + ", " + method + ", " + setting + ", camera " + std::to_string(camera) + ": " +
         what;
}

const std::vector<TruthFigures>& SceneFigures::truthOf(const BenchRun& run) const {
  return truths[run.setting / limits];
}

const BenchRun& SceneFigures::baselineOf(const BenchRun& run) const {
  const std::size_t unlimited = run.setting / limits * limits;
  return runs[unlimited * methods.size() + baseline];
}

std::vector<Breach> BenchReport::breaches() const {
  std::vector<Breach> found;
  for (const SceneFigures& scene : scenes) {
    for (const BenchRun& run : scene.runs) {
      if (run.first_breach) found.push_back(*run.first_breach);
    }
  }
  return found;
}

std::string BenchReport::verdict() const {
  const std::vector<Breach> found = breaches();
  if (!found.empty()) return "GUARANTEE BROKEN: " + found.front().line();
  std::size_t answers = 0;
  for (const SceneFigures& scene : scenes) {
    for (const BenchRun& run : scene.runs) answers += run.cameras.size() * scene.repeat;
  }
  return "guarantees held in all " + std::to_string(answers) + " answers";
}

}  // namespace culld

namespace culld::report {
namespace {

/// Sums over the cameras of a run, then divides once.
class Means {
 public:
  explicit Means(const std::vector<CameraFigures>& cameras) : cameras_(cameras) {}
  template <typename Get>
  double of(Get get) const {
    double sum = 0.0;
    for (const CameraFigures& c : cameras_) sum += static_cast<double>(get(c));
    return cameras_.empty() ? 0.0 : sum / static_cast<double>(cameras_.size());
  }

 private:
  const std::vector<CameraFigures>& cameras_;
};

std::optional<double> ratio(double a, double b) {
  if (!(b > 0.0)) return std::nullopt;
  return a / b;
}

void addErrors(const SceneFigures& scene, const BenchRun& run, RunSummary& sum) {
  for (const CameraFigures& camera : run.cameras) {
    sum.missed += camera.missed;
    sum.missed_subpixel += camera.missed_subpixel;
    sum.missed_px += camera.missed_px;
    if (!camera.said_px) continue;
    ++sum.lossy;
    sum.said_px += *camera.said_px;
    sum.lossy_missed_px += camera.missed_px;
    sum.exceeded += camera.exceeded ? 1U : 0U;
  }
  for (const TruthFigures& truth : scene.truthOf(run)) {
    sum.in_frustum += static_cast<double>(truth.in_frustum);
    sum.visible += static_cast<double>(truth.visible);
  }
  const auto cameras = static_cast<double>(std::max<std::size_t>(1, run.cameras.size()));
  sum.in_frustum /= cameras;
  sum.visible /= cameras;
  sum.answered = Means(run.cameras).of([](const auto& c) { return c.answered; });
  sum.excess = ratio(sum.answered, sum.visible);
  sum.culled_share = ratio(sum.in_frustum - sum.answered, sum.in_frustum - sum.visible);
}

void addTimes(const BenchRun& run, const BenchRun& baseline, RunSummary& sum) {
  std::vector<double> medians;
  for (const CameraFigures& camera : run.cameras) medians.push_back(camera.time_us.median);
  sum.mean_us = meanOf(medians);
  sum.cameras_us = spreadOf(std::move(medians));
  const Means means(run.cameras), before(baseline.cameras);
  const auto median = [](const CameraFigures& c) { return c.time_us.median; };
  const auto low = [](const CameraFigures& c) { return c.time_us.min; };
  sum.low_us = means.of(low);
  sum.high_us = means.of([](const auto& c) { return c.time_us.p95; });
  sum.relative = ratio(sum.mean_us, before.of(median));
  sum.relative_min = ratio(sum.low_us, before.of(low));
  sum.extra_us = sum.mean_us - before.of(median);
}

/// "raster 75 %, frustum 25 %", the largest share first.
std::string makersOf(const std::map<std::string, std::uint64_t>& made_by) {
  std::vector<std::pair<std::uint64_t, std::string>> order;
  std::uint64_t all = 0;
  for (const auto& [name, answers] : made_by) {
    order.emplace_back(answers, name);
    all += answers;
  }
  std::sort(order.rbegin(), order.rend());
  std::string text;
  for (const auto& [answers, name] : order) {
    text += (text.empty() ? "" : ", ") + name + " " +
            std::to_string((100 * answers + all / 2) / all) + " %";
  }
  return text;
}

}  // namespace

RunSummary summaryOf(const SceneFigures& scene, const BenchRun& run) {
  RunSummary sum;
  const BenchRun& baseline = scene.baselineOf(run);
  addErrors(scene, run, sum);
  addTimes(run, baseline, sum);
  const Means means(run.cameras);
  sum.answer_bytes = means.of([](const auto& c) { return c.answer_bytes; });
  sum.change_bytes = means.of([](const auto& c) { return c.change_bytes; });
  sum.out_of_budget = means.of([](const auto& c) { return c.out_of_budget; }) / scene.repeat;
  const auto work = [](const CameraFigures& c) { return c.work_us; };
  sum.work_us = means.of(work);
  sum.relative_work = ratio(sum.work_us, Means(baseline.cameras).of(work));
  if (!(sum.work_us > 0.0)) sum.relative_work.reset();  // the method does not price its work
  sum.made_by = makersOf(run.made_by);
  sum.nodes_visited = means.of([](const auto& c) { return c.stats.nodes_visited; });
  sum.tested = means.of([](const auto& c) { return c.stats.tested; });
  sum.plane_tests =
      means.of([](const auto& c) { return static_cast<double>(c.stats.plane_tests); });
  sum.depth_comparisons =
      means.of([](const auto& c) { return static_cast<double>(c.stats.depth_comparisons); });
  sum.occluders_drawn = means.of([](const auto& c) { return c.stats.occluders_drawn; });
  sum.triangles_drawn = means.of([](const auto& c) { return c.stats.triangles_drawn; });
  const double by_frustum = Means(baseline.cameras).of([](const auto& c) { return c.answered; });
  sum.outside = static_cast<double>(scene.objects) - by_frustum;
  sum.occluded = by_frustum - sum.answered;
  return sum;
}

}  // namespace culld::report
