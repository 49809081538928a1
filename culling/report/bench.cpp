#include "culling/report/bench.h"

#include <malloc.h>

#include <algorithm>
#include <memory>
#include <numeric>
#include <random>
#include <tuple>
#include <utility>

#include "culling/report/bench_check.h"
#include "culling/report/bench_picture.h"

namespace culld {
namespace {

using report::Asked;
using report::Checked;
using std::chrono::duration;

// Truths held at a time; the methods go through so many cameras once per repetition.
constexpr std::size_t kCamerasPerBlock = 32;
// What methods of class `hole` are asked for.
constexpr float kHolePx = 1.0F;

double microseconds(std::chrono::nanoseconds t) { return duration<double, std::micro>(t).count(); }

std::size_t heapBytes() {
  const auto books = mallinfo2();
  return books.uordblks + books.hblkhd;
}

TruthFigures figuresOf(std::size_t number, const OracleAnswer& truth) {
  TruthFigures figures;
  figures.camera = number;
  figures.in_frustum = truth.in_frustum.size();
  figures.visible = truth.visible.size();
  figures.subpixel = static_cast<std::size_t>(
      std::count(truth.subpixel.begin(), truth.subpixel.end(), std::uint8_t{1}));
  figures.rays = truth.rays;
  figures.unfound = truth.unfound_by_rays.byOneMoreTry();
  return figures;
}

/// One method at one setting, on its way over the cameras.
struct Runner {
  const Culler* culler = nullptr;
  Demand demand;
  std::size_t method = 0, setting = 0;
  std::unique_ptr<ViewState> view = std::make_unique<ViewState>();
  BenchRun figures;
  std::vector<ObjectId> before;              ///< answered to the camera before
  std::vector<std::vector<double>> time_us;  ///< per camera of the block
  report::WorstFrame worst;
};

class SceneBench {
 public:
  SceneBench(const BenchScene& scene, const BenchOptions& options, SceneFigures& figures)
      : scene_(scene), options_(options), figures_(figures) {}

  Result<void> run();

 private:
  void describe();
  Result<void> prepare();
  Result<void> runImage(std::size_t image);
  Result<void> runBlock(std::size_t image, std::size_t first, std::vector<Runner>& runners);
  void ask(Runner& runner, const Camera& camera, std::size_t index, std::size_t first,
           const OracleAnswer& truth, std::uint32_t repetition);
  void note(Runner& runner, std::size_t index, const Answer& answer, const Checked& checked,
            std::uint32_t repetition);
  std::vector<Runner> runnersFor(std::size_t image) const;
  Camera cameraAt(std::size_t image, std::size_t index) const;
  void draw();

  const BenchScene& scene_;
  const BenchOptions& options_;
  SceneFigures& figures_;
  std::unique_ptr<Oracle> oracle_;
  std::vector<std::unique_ptr<Culler>> cullers_;  ///< per method of the figures
  std::vector<report::WorstFrame> worst_;         ///< per run
  std::mt19937_64 random_{1};       // whoever follows whom in the caches, each does as often
  std::vector<std::size_t> turns_;  ///< the runners in the order of one camera
  std::size_t done_ = 0;
};

void SceneBench::describe() {
  figures_.name = scene_.name;
  figures_.repeat = options_.repeat;
  for (std::size_t i = 0; i < scene_.scene->objectCount(); ++i) {
    if (scene_.scene->instance(static_cast<ObjectId>(i)).active()) ++figures_.objects;
  }
  figures_.triangles = scene_.scene->triangleCount();
  figures_.scene_bytes = scene_.scene->bytes();
  std::vector<std::chrono::nanoseconds> limits{std::chrono::nanoseconds{0}};
  for (const auto limit : options_.limits) {
    if (std::find(limits.begin(), limits.end(), limit) == limits.end()) limits.push_back(limit);
  }
  std::vector<std::optional<ImageSize>> images(options_.images.begin(), options_.images.end());
  if (images.empty()) images.emplace_back();
  figures_.limits = limits.size();
  figures_.truths.resize(images.size());
  for (const auto& image : images) {
    for (const auto limit : limits) figures_.settings.push_back({image, limit});
  }
}

Result<void> SceneBench::prepare() {
  figures_.refused = scene_.refused;
  for (std::size_t i = 0; i < scene_.methods.size(); ++i) {
    const BenchMethod& wanted = scene_.methods[i];
    const MethodInfo info = wanted.method->info();
    MethodFigures figures;
    figures.name = wanted.name;
    figures.style = wanted.style;
    figures.source = info.source;
    figures.needs = info.needs;
    figures.guarantee = info.guarantee;
    const auto start = options_.clock.now();
    auto culler = wanted.method->prepare(scene_.scene, options_.clock);
    figures.prepare_ms = 1e-3 * microseconds(options_.clock.now() - start);
    if (!culler) {
      if (i == scene_.baseline) return std::move(culler).error();
      figures_.refused.push_back({wanted.name, culler.error().message});
      continue;
    }
    if (i == scene_.baseline) figures_.baseline = cullers_.size();
    figures.prepared_bytes = culler.value()->preparedBytes();
    cullers_.push_back(std::move(culler).value());
    figures_.methods.push_back(std::move(figures));
  }
  return Done{};
}

Camera SceneBench::cameraAt(std::size_t image, std::size_t index) const {
  Camera camera = scene_.cameras[index];
  const auto& size = figures_.settings[image * figures_.limits].image;
  if (size) {
    camera.width_px = size->width_px;
    camera.height_px = size->height_px;
  }
  return camera;
}

std::vector<Runner> SceneBench::runnersFor(std::size_t image) const {
  std::vector<Runner> runners;
  for (std::size_t s = image * figures_.limits; s < (image + 1) * figures_.limits; ++s) {
    for (std::size_t m = 0; m < cullers_.size(); ++m) {
      Runner runner;
      runner.culler = cullers_[m].get();
      runner.demand.guarantee = figures_.methods[m].guarantee;
      runner.demand.hole_px = kHolePx;
      runner.demand.time = figures_.settings[s].time;
      runner.figures.method = runner.method = m;
      runner.figures.setting = runner.setting = s;
      runner.figures.cameras.resize(scene_.cameras.size());
      runners.push_back(std::move(runner));
    }
  }
  return runners;
}

Result<void> SceneBench::runImage(std::size_t image) {
  std::vector<Runner> runners = runnersFor(image);
  turns_.resize(runners.size());
  std::iota(turns_.begin(), turns_.end(), std::size_t{0});
  for (Runner& runner : runners) {  // first use of memory is not what a camera costs
    (void)runner.culler->cull(cameraAt(image, 0), runner.demand, *runner.view);
  }
  for (std::size_t first = 0; first < scene_.cameras.size(); first += kCamerasPerBlock) {
    if (auto ran = runBlock(image, first, runners); !ran) return ran;
  }
  for (Runner& runner : runners) {
    const std::size_t with_view = heapBytes();
    runner.view.reset();
    const std::size_t without = heapBytes();
    runner.figures.view_bytes = with_view > without ? with_view - without : 0;
    figures_.runs.push_back(std::move(runner.figures));
    worst_.push_back(std::move(runner.worst));
  }
  return Done{};
}

Result<void> SceneBench::runBlock(std::size_t image, std::size_t first,
                                  std::vector<Runner>& runners) {
  const std::size_t count = std::min(kCamerasPerBlock, scene_.cameras.size() - first);
  std::vector<OracleAnswer> truths;
  for (std::size_t i = first; i < first + count; ++i) {
    auto truth = oracle_->look(cameraAt(image, i), options_.truth);
    if (!truth) return std::move(truth).error();
    truths.push_back(std::move(truth).value());
    figures_.truths[image].push_back(figuresOf(scene_.numbers[i], truths.back()));
    if (options_.progress) {
      options_.progress(++done_, scene_.cameras.size() * figures_.truths.size());
    }
  }
  for (Runner& runner : runners) runner.time_us.assign(count, {});
  for (std::uint32_t repetition = 0; repetition < options_.repeat; ++repetition) {
    for (std::size_t i = 0; i < count; ++i) {
      const Camera camera = cameraAt(image, first + i);
      std::shuffle(turns_.begin(), turns_.end(), random_);
      for (const std::size_t turn : turns_) {
        ask(runners[turn], camera, first + i, first, truths[i], repetition);
      }
    }
  }
  for (Runner& runner : runners) {
    for (std::size_t i = 0; i < count; ++i) {
      CameraFigures& figures = runner.figures.cameras[first + i];
      figures.time_us = report::spreadOf(std::move(runner.time_us[i]));
      figures.answered /= options_.repeat;
      figures.work_us /= options_.repeat;
    }
  }
  return Done{};
}

void SceneBench::ask(Runner& runner, const Camera& camera, std::size_t index, std::size_t first,
                     const OracleAnswer& truth, std::uint32_t repetition) {
  const auto start = options_.clock.now();
  Answer answer = runner.culler->cull(camera, runner.demand, *runner.view);
  runner.time_us[index - first].push_back(microseconds(options_.clock.now() - start));
  const Asked asked{*oracle_, *scene_.scene, camera, truth, options_.truth, runner.demand};
  const Checked checked = report::checkAnswer(asked, answer);
  if (checked.malformed) answer.visible.clear();  // nothing to be counted, sent or drawn
  note(runner, index, answer, checked, repetition);
  runner.worst.consider(index, answer.visible, checked, truth.visible.size());
  if (repetition == 0) runner.before = std::move(answer.visible);
}

void SceneBench::note(Runner& runner, std::size_t index, const Answer& answer,
                      const Checked& checked, std::uint32_t repetition) {
  CameraFigures& figures = runner.figures.cameras[index];
  figures.answered += static_cast<double>(answer.visible.size());
  figures.work_us += microseconds(answer.stats.work);
  if (answer.out_of_budget) ++figures.out_of_budget;
  if (std::tuple(checked.missed_px, checked.missed, checked.missed_subpixel) >
      std::tuple(figures.missed_px, figures.missed, figures.missed_subpixel)) {
    figures.missed_px = checked.missed_px;
    figures.missed = checked.missed;
    figures.missed_subpixel = checked.missed_subpixel;
  }
  if (answer.guarantee == Guarantee::kApproximate) {
    const auto said_px = static_cast<double>(answer.missed_px);
    if (repetition == 0) figures.said_px = said_px;
    figures.exceeded = figures.exceeded || checked.missed_px > said_px;
  }
  if (!answer.made_by.empty()) ++runner.figures.made_by[std::string(answer.made_by)];
  if (repetition == 0) {
    figures.stats = answer.stats;
    if (options_.wire_bytes) {
      figures.answer_bytes = options_.wire_bytes({}, answer.visible);
      figures.change_bytes = options_.wire_bytes(runner.before, answer.visible);
    }
  }
  if (checked.breach.empty()) return;
  ++runner.figures.breaches;
  if (runner.figures.first_breach) return;
  runner.figures.first_breach =
      Breach{scene_.name, figures_.methods[runner.method].name,
             figures_.settings[runner.setting].name(), scene_.numbers[index], checked.breach};
}

/// The frame to look at: where most was missed; if nothing was, where the method that keeps least
/// on the whole keeps most in vain.
void SceneBench::draw() {
  std::size_t chosen = 0;
  const auto answered = [](const BenchRun& run) {
    double sum = 0.0;
    for (const CameraFigures& figures : run.cameras) sum += figures.answered;
    return sum;
  };
  for (std::size_t i = 1; i < worst_.size(); ++i) {
    if (worst_[i].missed() > worst_[chosen].missed() ||
        (worst_[i].missed() == worst_[chosen].missed() &&
         answered(figures_.runs[i]) < answered(figures_.runs[chosen]))) {
      chosen = i;
    }
  }
  const BenchRun& run = figures_.runs[chosen];
  const report::WorstFrame& worst = worst_[chosen];
  const Camera camera = cameraAt(run.setting / figures_.limits, worst.camera());
  figures_.picture_title = "camera " + std::to_string(scene_.numbers[worst.camera()]) + ", " +
                           figures_.methods[run.method].name + ", " +
                           figures_.settings[run.setting].name();
  // A scene whose picture cannot be drawn (no memory) still has its figures.
  const auto png = worst.draw(*scene_.scene, *oracle_, camera, options_.truth,
                              scene_.name + ", " + figures_.picture_title);
  if (png) figures_.picture_png = png.value();
}

Result<void> SceneBench::run() {
  describe();
  if (auto prepared = prepare(); !prepared) return prepared;
  auto oracle = Oracle::build(scene_.scene);
  if (!oracle) return std::move(oracle).error();
  oracle_ = std::move(oracle).value();
  for (std::size_t image = 0; image < figures_.truths.size(); ++image) {
    if (auto ran = runImage(image); !ran) return ran;
  }
  draw();
  return Done{};
}

}  // namespace

Result<SceneFigures> benchScene(const BenchScene& scene, const BenchOptions& options) {
  SceneFigures figures;
  if (auto ran = SceneBench(scene, options, figures).run(); !ran) return std::move(ran).error();
  return figures;
}

}  // namespace culld
