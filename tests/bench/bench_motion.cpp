// bench_motion: what a motion bound costs method `raster`, in objects answered and in time, radius
// against radius over the same cameras in interleaved repetitions. Rows are those of
// docs/measured.md, "Valid in motion".
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "culling/culler.h"
#include "culling/scene/gltf_loader.h"
#include "protocol/camera_file.h"
#include "server/translate.h"

namespace culld {
namespace {

using Time = std::chrono::steady_clock;

struct Arguments {
  std::vector<std::string> files;
  std::vector<double> radii_m{0.15, 0.3, 0.6, 1.2};
  double angle_rad = 0.0;
  std::size_t repeat = 9, every = 1;
};

/// One radius over all cameras: sums of what is answered and of the least times.
struct Run {
  MotionBound motion;
  double answered = 0.0, in_frustum = 0.0, least_us = 0.0;
  ViewState view;
};

/// The radii in turn, and again, so that a slow moment of the machine meets all of them.
void look(const Culler& culler, Camera camera, std::size_t repeat, std::vector<Run>& runs) {
  std::vector<double> least_us(runs.size(), std::numeric_limits<double>::infinity());
  for (std::size_t r = 0; r < repeat; ++r) {
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const std::size_t i = (k + r) % runs.size();
      camera.motion = runs[i].motion;
      const auto start = Time::now();
      const Answer answer = culler.cull(camera, {}, runs[i].view);
      const double us = std::chrono::duration<double, std::micro>(Time::now() - start).count();
      least_us[i] = std::min(least_us[i], us);
      if (r != 0) continue;
      runs[i].answered += static_cast<double>(answer.visible.size());
      runs[i].in_frustum += static_cast<double>(answer.stats.in_frustum);
    }
  }
  for (std::size_t i = 0; i < runs.size(); ++i) runs[i].least_us += least_us[i];
}

Result<void> measure(const std::string& file, const Arguments& arguments) {
  const std::filesystem::path path(file);
  auto scene = loadGltfFile(file);
  if (!scene) return std::move(scene).error();
  auto cameras =
      protocol::readCameraFile(std::filesystem::path(path).replace_extension(".cameras.json"));
  if (!cameras) return invalidInput(cameras.error().message);
  auto culler = findMethod("raster")->prepare(scene.value());
  if (!culler) return std::move(culler).error();
  std::vector<Run> runs(arguments.radii_m.size() + 1);
  for (std::size_t i = 0; i < arguments.radii_m.size(); ++i) {
    runs[i + 1].motion = {arguments.radii_m[i], arguments.angle_rad};
  }
  std::size_t looks = 0;
  for (std::size_t c = 0; c < cameras.value().size(); c += arguments.every) {
    auto camera = server::toEngine(cameras.value()[c]);
    if (!camera) return std::move(camera).error();
    look(*culler.value(), camera.value(), arguments.repeat, runs);
    ++looks;
  }
  const double share = 1.0 / static_cast<double>(looks);
  std::printf("| %s | %zu | %.1f of %.1f |", path.stem().c_str(), looks, runs[0].answered * share,
              runs[0].in_frustum * share);
  for (const Run& run : runs) {
    if (run.motion.still()) continue;
    std::printf(" %.3f / %.2f / %.2f |", run.answered / runs[0].answered,
                run.in_frustum / runs[0].answered, run.least_us / runs[0].least_us);
  }
  std::printf("\n");
  std::fflush(stdout);
  return Done{};
}

}  // namespace
}  // namespace culld

int main(int argc, char** argv) try {
  using namespace culld;
  Arguments arguments;
  CLI::App app("what a motion bound costs method raster");
  app.add_option("SCENES", arguments.files, "X.glb, with X.cameras.json next to it")->required();
  app.add_option("--radii", arguments.radii_m, "metres")
      ->delimiter(',')
      ->check(CLI::PositiveNumber);
  app.add_option("--angle", arguments.angle_rad, "radians")->check(CLI::NonNegativeNumber);
  app.add_option("--repeat", arguments.repeat, "repetitions")->check(CLI::Range(1, 10'000));
  app.add_option("--every", arguments.every, "each N-th camera")->check(CLI::Range(1, 1'000'000));
  CLI11_PARSE(app, argc, argv);
  std::printf("| scene | cameras | answered of those in the frustum, standing still |");
  for (const double radius : arguments.radii_m) {
    std::printf(" %g m: answered / in frustum / time, each to still |", radius);
  }
  std::printf("\n");
  for (const std::string& file : arguments.files) {
    const auto ok = measure(file, arguments);
    if (!ok) {
      std::fprintf(stderr, "bench_motion: %s\n", ok.error().message.c_str());
      return 2;
    }
  }
  return 0;
} catch (const std::exception& failure) {
  std::fprintf(stderr, "bench_motion: %s\n", failure.what());
  return 2;
}
