// bench_auto: what `auto` costs and sends against `frustum`, `raster` and the best of all methods,
// over whole camera paths, in interleaved repetitions. Rows are those of docs/measured.md, "What
// auto leaves out".
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "culling/core/prices.h"
#include "culling/culler.h"
#include "culling/planner/auto_method.h"
#include "culling/planner/scene_profile.h"
#include "culling/scene/gltf_loader.h"
#include "culling/spatial/frustum_walk.h"
#include "protocol/camera_file.h"
#include "server/translate.h"
#include "tests/scenes/city.h"
#include "tests/scenes/landscapes.h"

namespace culld {
namespace {

using Time = std::chrono::steady_clock;

struct Scene {
  std::string name;
  SnapshotPtr snapshot;
  std::vector<Camera> cameras;
};

struct Run {
  std::vector<double> path_us;  ///< mean per camera, one for each repetition
  double work_us = 0.0, objects = 0.0, triangles = 0.0;  ///< per camera
  std::size_t other_stage = 0;  ///< cameras that another method than `frustum` answered

  double least() const { return *std::min_element(path_us.begin(), path_us.end()); }
  double median() const {
    std::vector<double> sorted = path_us;
    std::sort(sorted.begin(), sorted.end());
    return sorted[sorted.size() / 2];
  }
  double priceUs() const { return work_us + sentUs(); }
  double sentUs() const {
    return (objects * static_cast<double>(kObjectPrice.count()) +
            triangles * static_cast<double>(kTrianglePrice.count())) *
           1e-3;
  }
};

struct Contender {
  std::string name;
  std::unique_ptr<Culler> culler;
  Run run;
};

void count(const SceneSnapshot& scene, const Answer& answer, double share, Run& run) {
  run.work_us += share * 1e-3 * static_cast<double>(answer.stats.work.count());
  run.objects += share * static_cast<double>(answer.visible.size());
  for (const ObjectId id : answer.visible) {
    run.triangles +=
        share * static_cast<double>(scene.mesh(scene.instance(id).mesh).triangles.size());
  }
  if (!answer.made_by.empty() && answer.made_by != "frustum") ++run.other_stage;
}

/// Along the path, the contenders camera by camera in turn, each repetition with fresh views.
void race(const Scene& scene, int repeat, std::vector<Contender*> contenders) {
  const double share = 1.0 / static_cast<double>(scene.cameras.size());
  for (int r = 0; r < repeat; ++r) {
    std::vector<ViewState> views(contenders.size());
    std::vector<double> sum_us(contenders.size(), 0.0);
    for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
      for (std::size_t k = 0; k < contenders.size(); ++k) {
        const std::size_t i = (k + c + static_cast<std::size_t>(r)) % contenders.size();
        const auto start = Time::now();
        const Answer answer = contenders[i]->culler->cull(scene.cameras[c], {}, views[i]);
        sum_us[i] += std::chrono::duration<double, std::micro>(Time::now() - start).count();
        if (r == 0) count(*scene.snapshot, answer, share, contenders[i]->run);
      }
    }
    for (std::size_t i = 0; i < contenders.size(); ++i) {
      contenders[i]->run.path_us.push_back(sum_us[i] * share);
    }
  }
}

/// All that promise what `auto` promises and take the scene; `auto` itself comes last.
std::vector<Contender> contendersFor(const Scene& scene) {
  const SceneProfile profile = profileScene(*scene.snapshot);
  std::vector<Contender> all;
  for (const Method* method : allMethods()) {
    const MethodInfo info = method->info();
    if (info.guarantee != Guarantee::kConservative || !method->accepts(profile)) continue;
    auto culler = method->prepare(scene.snapshot);
    if (culler) all.push_back({std::string(info.name), std::move(culler).value(), {}});
  }
  return all;
}

void measure(const Scene& scene, int repeat) {
  std::vector<Contender> all = contendersFor(scene);
  Contender &frustum = all[0], &raster = all[1], &chosen = all.back();
  race(scene, repeat, {&frustum, &chosen});
  for (Contender& other : std::span(all).subspan(1, all.size() - 2)) {
    race(scene, std::max(1, repeat / 8), {&other});
  }
  const auto best = std::min_element(all.begin(), all.end() - 1, [](const auto& x, const auto& y) {
    return x.run.priceUs() < y.run.priceUs();
  });
  const Run &f = frustum.run, &r = raster.run, &a = chosen.run;
  std::printf(
      "| %s | %zu | %.1f | %.1f | %.1f | %.1f / %.1f / %.1f | %.3f / %.3f | `%s` | %.3f | %.3f | "
      "%zu of %zu |\n",
      scene.name.c_str(), scene.snapshot->objectCount(), f.least(), r.least(), a.least(), f.objects,
      r.objects, a.objects, a.least() / f.least(), a.median() / f.median(), best->name.c_str(),
      a.priceUs() / best->run.priceUs(),
      (a.least() + a.sentUs()) / (best->run.least() + best->run.sentUs()), a.other_stage,
      scene.cameras.size());
  std::printf(
      "  counted / measured work: frustum %.2f raster %.2f; kept %zu bytes (frustum %zu); %s\n",
      f.work_us / f.least(), r.work_us / r.least(), chosen.culler->preparedBytes(),
      frustum.culler->preparedBytes(), planOf(*chosen.culler)->why.c_str());
  std::fflush(stdout);
}

Scene generated(std::string name, const scenes::Model& model,
                const std::vector<scenes::CameraSpec>& specs) {
  Scene scene{std::move(name), scenes::toSnapshot(model), {}};
  for (const scenes::CameraSpec& spec : specs) scene.cameras.push_back(toCamera(spec).value());
  return scene;
}

std::vector<Scene> generatedScenes() {
  std::vector<Scene> all;
  const auto add = [&](const char* name, const scenes::Landscape& made) {
    all.push_back(generated(name, made.model, made.cameras));
  };
  add("arena (generated)", scenes::arena({}));
  add("arena, 20 000", scenes::arena({.objects = 20'000}));
  add("sparse terrain (generated)", scenes::sparseTerrain({}));
  add("sparse terrain, 20 000", scenes::sparseTerrain({.objects = 20'000}));
  add("closed rooms (generated)", scenes::closedRooms({}));
  const scenes::City city = scenes::generateCity({.objects = 20'000});
  all.push_back(generated("city (generated)", city.model, city.cameras));
  add("closed rooms, 100", scenes::closedRooms({.objects = 100}));
  return all;
}

/// X.glb with X.cameras.json next to it.
Result<Scene> fromFile(const std::string& file) {
  const std::filesystem::path path(file);
  auto snapshot = loadGltfFile(file);
  if (!snapshot) return std::move(snapshot).error();
  auto cameras =
      protocol::readCameraFile(std::filesystem::path(path).replace_extension(".cameras.json"));
  if (!cameras) return invalidInput(cameras.error().message);
  Scene scene{path.stem().string(), snapshot.value(), {}};
  for (const protocol::Camera& camera : cameras.value()) {
    auto made = server::toEngine(camera);
    if (!made) return std::move(made).error();
    scene.cameras.push_back(made.value());
  }
  return scene;
}

/// Objects below which a flat list beats a hierarchy: WideBvh::kFewObjects.
void measureFlatLists() {
  std::printf("objects | flat list us | hierarchy us\n");
  for (std::size_t objects = 32; objects <= 2048; objects *= 2) {
    const auto size = static_cast<std::uint32_t>(std::max<std::size_t>(400, objects));
    const scenes::Landscape made = scenes::closedRooms({.objects = size, .frames = 400});
    scenes::Model model = made.model;
    model.nodes.resize(objects);
    const SnapshotPtr scene = scenes::toSnapshot(model);
    const WideBvh trees[] = {WideBvh::flat(*scene), WideBvh::build(*scene)};
    double least_us[2] = {1e9, 1e9};
    for (int r = 0; r < 40; ++r) {
      for (std::size_t t = 0; t < 2; ++t) {
        const auto start = Time::now();
        for (const scenes::CameraSpec& spec : made.cameras) {
          const Camera camera = toCamera(spec).value();
          std::vector<ObjectId> ids;
          appendInFrustum(trees[t], FrustumTest(camera, trees[t]), Deadline(steadyClock(), {}, {}),
                          ids);
          sortIds(ids, objects);
        }
        const double us = std::chrono::duration<double, std::micro>(Time::now() - start).count();
        least_us[t] = std::min(least_us[t], us / static_cast<double>(made.cameras.size()));
      }
    }
    std::printf("%7zu | %12.2f | %12.2f\n", objects, least_us[0], least_us[1]);
  }
}

}  // namespace
}  // namespace culld

int main(int argc, char** argv) try {
  using namespace culld;
  std::vector<std::string> files;
  int repeat = 15;
  bool flat = false, no_generated = false;
  CLI::App app("auto against the methods that it chooses from");
  app.add_option("SCENES", files, "X.glb, with X.cameras.json next to it");
  app.add_option("--repeat", repeat, "repetitions of each path")->check(CLI::Range(1, 10'000));
  app.add_flag("--flat-lists", flat, "flat lists of boxes against hierarchies instead");
  app.add_flag("--no-generated", no_generated, "given scenes only");
  CLI11_PARSE(app, argc, argv);
  if (flat) {
    measureFlatLists();
    return 0;
  }
  std::printf(
      "| scene | objects | frustum us | raster us | auto us | sent: frustum / raster / auto "
      "| auto / frustum time, min / median | best | price, counted | price, timed | occlusion |\n");
  if (!no_generated) {
    for (const Scene& scene : generatedScenes()) measure(scene, repeat);
  }
  for (const std::string& file : files) {
    const auto scene = fromFile(file);
    if (!scene) {
      std::fprintf(stderr, "bench_auto: %s\n", scene.error().message.c_str());
      return 2;
    }
    measure(scene.value(), repeat);
  }
  return 0;
} catch (const std::exception& failure) {
  std::fprintf(stderr, "bench_auto: %s\n", failure.what());
  return 2;
}
