// bench_pairs: what a question about pairs costs: viewers and targets the size of players stand at
// eyes of the scene's cameras. Rows are those of docs/measured.md, "Pairs".
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "culling/pairs/pairs.h"
#include "culling/scene/gltf_loader.h"
#include "protocol/camera_file.h"
#include "server/translate.h"

namespace culld {
namespace {

struct Arguments {
  std::vector<std::string> files;
  std::size_t viewers = 20, targets = 20, repeat = 200;
  double radius_m = 0.0;
};

/// Half of what a player fills.
constexpr glm::dvec3 kHalf(0.4, 0.9, 0.4);

/// `count` eyes, spread over all cameras.
Result<std::vector<Place>> placesAt(const std::vector<protocol::Camera>& cameras, std::size_t count,
                                    bool boxes, double radius_m) {
  std::vector<Place> places;
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = (i * cameras.size() / count + (boxes ? cameras.size() / 2 : 0));
    auto camera = server::toEngine(cameras[at % cameras.size()]);
    if (!camera) return std::move(camera).error();
    const glm::dvec3 eye = camera.value().origin_world;
    const glm::dvec3 half = boxes ? kHalf : glm::dvec3(0.0);
    places.push_back({{eye - half, eye + half}, radius_m});
  }
  return places;
}

Result<void> measure(const std::string& file, const Arguments& a) {
  auto scene = loadGltfFile(file);
  if (!scene) return std::move(scene).error();
  const std::filesystem::path path(file);
  auto cameras =
      protocol::readCameraFile(std::filesystem::path(path).replace_extension(".cameras.json"));
  if (!cameras) return invalidInput(cameras.error().message);
  const auto viewers = placesAt(cameras.value(), a.viewers, false, a.radius_m);
  if (!viewers) return viewers.error();
  const auto targets = placesAt(cameras.value(), a.targets, true, a.radius_m);
  if (!targets) return targets.error();
  const auto start = steadyClock().now();
  const PairsCuller culler(*scene.value());
  const auto prepared = steadyClock().now() - start;
  std::vector<double> us;
  PairsAnswer last;
  for (std::size_t r = 0; r < a.repeat; ++r) {
    auto answer = culler.cull(viewers.value(), targets.value());
    if (!answer) return answer.error();
    last = std::move(answer).value();
    us.push_back(std::chrono::duration<double, std::micro>(last.time).count());
  }
  std::sort(us.begin(), us.end());
  const double pairs = static_cast<double>(a.viewers * a.targets);
  std::printf("| %s | %zu, %.1f MB, %.0f ms | %.1f %% | %.1f | %.1f | %.2f / %.2f us |\n",
              path.stem().c_str(), culler.blockers(), 1e-6 * static_cast<double>(culler.bytes()),
              std::chrono::duration<double, std::milli>(prepared).count(),
              100.0 * static_cast<double>(last.hidden) / pairs,
              static_cast<double>(last.nodes_visited) / pairs,
              static_cast<double>(last.tested) / pairs, us.front() / pairs,
              us[us.size() / 2] / pairs);
  return Done{};
}

}  // namespace
}  // namespace culld

int main(int argc, char** argv) try {
  using namespace culld;
  Arguments arguments;
  CLI::App app("what a question about pairs costs");
  app.add_option("SCENES", arguments.files, "X.glb, with X.cameras.json next to it")->required();
  app.add_option("--viewers", arguments.viewers)->check(CLI::Range(1, 10'000));
  app.add_option("--targets", arguments.targets)->check(CLI::Range(1, 10'000));
  app.add_option("--radius", arguments.radius_m, "metres")->check(CLI::NonNegativeNumber);
  app.add_option("--repeat", arguments.repeat, "repetitions")->check(CLI::Range(1, 100'000));
  CLI11_PARSE(app, argc, argv);
  std::printf(
      "| scene | blockers | hidden | nodes a pair | tests a pair | least / median a pair |\n");
  for (const std::string& file : arguments.files) {
    if (const auto ok = measure(file, arguments); !ok) {
      std::fprintf(stderr, "bench_pairs: %s\n", ok.error().message.c_str());
      return 2;
    }
  }
  return 0;
} catch (const std::exception& failure) {
  std::fprintf(stderr, "bench_pairs: %s\n", failure.what());
  return 2;
}
