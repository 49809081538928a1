// bench_dump: method `raster` on a benchmark dump, frame by frame against its truth file.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "culling/culler.h"
#include "tests/bench/dump_scene.h"

namespace culld::bench {
namespace {

using Time = std::chrono::steady_clock;

constexpr std::size_t kEvictBytes = std::size_t{64} << 20;  ///< beyond a core's own caches

struct Settings {
  ImageSize image;
  int repeat = 21;
  Demand demand;
  MotionBound motion;
};

struct Frame {
  std::uint32_t camera = 0;
  double ms_min = 0.0, ms_median = 0.0, ms_cold = 0.0, scan_ms_min = 0.0;
  std::size_t kept = 0, false_visible = 0, false_hidden = 0;
  CullStats stats;
};

double msSince(Time::time_point start) {
  return std::chrono::duration<double, std::milli>(Time::now() - start).count();
}

/// Least and median time of `run`.
template <typename Run>
std::array<double, 2> timed(int repeat, const Run& run) {
  std::vector<double> ms;
  for (int r = 0; r < repeat; ++r) {
    const auto start = Time::now();
    run();
    ms.push_back(msSince(start));
  }
  std::sort(ms.begin(), ms.end());
  return {ms.front(), ms[ms.size() / 2]};
}

/// Walks through more memory than the caches hold.
void evictCaches() {
  static std::vector<std::uint64_t> memory(kEvictBytes / sizeof(std::uint64_t), 1);
  for (std::size_t i = 0; i < memory.size(); i += 8) memory[i] = memory[i] * 3 + i;
}

void judge(const Answer& answer, const Dump& dump, const TruthFrame& truth, Frame& frame) {
  std::vector<std::uint8_t> kept(dump.objects.size(), 0);
  for (const ObjectId id : answer.visible) {
    if (id >= dump.objects.size()) continue;  // an occluder
    kept[id] = 1;
    ++frame.kept;
  }
  std::size_t found = 0;
  for (const auto& [object, samples] : truth.seen) found += kept[object];
  frame.false_hidden = truth.seen.size() - found;
  frame.false_visible = frame.kept - found;
}

class Bench {
 public:
  Bench(const Dump& dump, const Settings& settings)
      : dump_(dump),
        settings_(settings),
        culler_(findMethod("raster")->prepare(toSnapshot(dump)).value()) {}

  Result<Frame> run(const TruthFrame& truth) {
    const DumpCamera& dumped = dump_.cameras[truth.camera];
    auto camera = toCamera(dumped, settings_.image);
    if (!camera) return std::move(camera).error();
    camera.value().motion = settings_.motion;
    Frame frame;
    frame.camera = truth.camera;
    const Answer answer = culler_->cull(camera.value(), settings_.demand, view_);
    judge(answer, dump_, truth, frame);
    frame.stats = answer.stats;
    const auto cull = [&] { culler_->cull(camera.value(), settings_.demand, view_); };
    const auto warm = timed(settings_.repeat, cull);
    frame.ms_min = warm[0];
    frame.ms_median = warm[1];
    frame.ms_cold = 1e9;
    for (int r = 0; r < std::min(settings_.repeat, 5); ++r) {
      evictCaches();
      frame.ms_cold = std::min(frame.ms_cold, timed(1, cull)[0]);
    }
    frame.scan_ms_min = timed(std::min(settings_.repeat, 5),
                              [&] { scanned_ += scanBoxes(dump_.objects, dumped); })[0];
    return frame;
  }

  std::uint64_t scanned() const { return scanned_; }

 private:
  const Dump& dump_;
  Settings settings_;
  std::unique_ptr<Culler> culler_;
  ViewState view_;
  std::uint64_t scanned_ = 0;  ///< so that no compiler leaves the scan out
};

template <typename Value>
double mean(const std::vector<Frame>& frames, const Value& value) {
  double sum = 0.0;
  for (const Frame& frame : frames) sum += static_cast<double>(value(frame));
  return frames.empty() ? 0.0 : sum / static_cast<double>(frames.size());
}

double boxTests(const CullStats& stats) {
  return static_cast<double>(stats.nodes_visited) + stats.tested;
}

nlohmann::ordered_json summary(const std::vector<Frame>& frames) {
  nlohmann::ordered_json out;
  double worst = 0.0;
  std::size_t false_hidden = 0;
  for (const Frame& frame : frames) {
    worst = std::max(worst, frame.ms_median);
    false_hidden += frame.false_hidden;
  }
  out["frames"] = frames.size();
  out["ms_min_mean"] = mean(frames, [](const Frame& f) { return f.ms_min; });
  out["ms_median_mean"] = mean(frames, [](const Frame& f) { return f.ms_median; });
  out["ms_cold_mean"] = mean(frames, [](const Frame& f) { return f.ms_cold; });
  out["ms_worst"] = worst;
  out["scan_ms_min_mean"] = mean(frames, [](const Frame& f) { return f.scan_ms_min; });
  out["kept_mean"] = mean(frames, [](const Frame& f) { return f.kept; });
  out["false_visible_mean"] = mean(frames, [](const Frame& f) { return f.false_visible; });
  out["false_hidden_total"] = false_hidden;
  out["nodes_mean"] = mean(frames, [](const Frame& f) { return f.stats.nodes_visited; });
  out["box_tests_mean"] = mean(frames, [](const Frame& f) { return boxTests(f.stats); });
  out["meshes_mean"] = mean(frames, [](const Frame& f) { return f.stats.occluders_drawn; });
  out["triangles_mean"] = mean(frames, [](const Frame& f) { return f.stats.triangles_drawn; });
  return out;
}

void printFrame(const Frame& f) {
  std::printf("%6u %8.4f %8.4f %8.4f %8.3f %7zu %7zu %7zu %7u %7.0f %7u %9u\n", f.camera, f.ms_min,
              f.ms_median, f.ms_cold, f.scan_ms_min, f.kept, f.false_visible, f.false_hidden,
              f.stats.nodes_visited, boxTests(f.stats), f.stats.occluders_drawn,
              f.stats.triangles_drawn);
}

Result<std::vector<Frame>> runAll(const Dump& dump, const Truth& truth, const Settings& settings,
                                  bool print) {
  Bench bench(dump, settings);
  std::vector<Frame> frames;
  if (print) {
    std::printf(
        "camera   min ms   median     cold  scan ms    kept   false-   false-   nodes"
        "   tests  meshes triangles\n%44s visible  hidden\n",
        "");
  }
  for (const TruthFrame& frame : truth.frames) {
    auto done = bench.run(frame);
    if (!done) return std::move(done).error();
    frames.push_back(done.value());
    if (print) printFrame(frames.back());
  }
  return frames;
}

int run(const std::string& dump_file, const std::string& truth_file, const Settings& settings,
        bool json) {
  const auto refuse = [](const std::string& why) {
    std::fprintf(stderr, "bench_dump: %s\n", why.c_str());
    return 2;
  };
  auto dump = readDump(dump_file);
  if (!dump) return refuse(dump.error().message);
  auto truth = readTruth(truth_file, dump.value());
  if (!truth) return refuse(truth.error().message);
  auto frames = runAll(dump.value(), truth.value(), settings, !json);
  if (!frames) return refuse(dump_file + ": " + frames.error().message);
  const auto totals = summary(frames.value());
  std::printf("%s\n", totals.dump(json ? -1 : 2).c_str());
  return totals["false_hidden_total"] == 0 ? 0 : 1;
}

}  // namespace
}  // namespace culld::bench

int main(int argc, char** argv) try {
  std::string dump, truth;
  culld::bench::Settings settings;
  bool json = false, rectangles = false;
  CLI::App app(
      "Method raster on a benchmark dump, against its truth; exit 1 if it hid what was seen");
  app.add_option("DUMP", dump)->required();
  app.add_option("--truth", truth, "its truth file")->required();
  app.add_option("--width", settings.image.width_px, "pixels")->check(CLI::Range(1, 65536));
  app.add_option("--height", settings.image.height_px, "pixels")->check(CLI::Range(1, 65536));
  app.add_option("--repeat", settings.repeat, "repetitions of each frame")
      ->check(CLI::Range(1, 10'000));
  app.add_option("--radius", settings.motion.radius_m, "metres within which the answer holds too")
      ->check(CLI::NonNegativeNumber);
  app.add_flag("--rectangles", rectangles, "no object is asked by its own triangles");
  app.add_flag("--json", json, "totals only, as one line of JSON");
  CLI11_PARSE(app, argc, argv);
  settings.demand.own_triangles = !rectangles;
  return culld::bench::run(dump, truth, settings, json);
} catch (const std::exception& failure) {
  std::fprintf(stderr, "bench_dump: %s\n", failure.what());
  return 2;
}
