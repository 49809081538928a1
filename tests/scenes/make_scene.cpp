// make_scene: writes generated scenes, and paths through given ones, to files: for the demo and for
// trying things by hand.
#include <CLI/CLI.hpp>
#include <cstdint>
#include <exception>
#include <fstream>
#include <iostream>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "culling/scene/gltf_loader.h"
#include "tests/scenes/city.h"
#include "tests/scenes/landscapes.h"
#include "tests/scenes/random_scene.h"
#include "tests/scenes/tour.h"

namespace {

constexpr int kCannotWrite = 74;

constexpr std::uint32_t kTourFrames = 24;

struct Arguments {
  std::string glb, cameras;
  std::uint32_t tour_frames = kTourFrames;
  culld::scenes::CityOptions city;
  culld::scenes::RandomSceneOptions random;
  culld::scenes::LandscapeOptions landscape;
};

using MakeLandscape = culld::scenes::Landscape (*)(const culld::scenes::LandscapeOptions&);

void declareLandscape(CLI::App& command, Arguments& arguments) {
  command.add_option("-o,--output", arguments.glb, "the .glb to write")->required();
  command.add_option("--cameras", arguments.cameras, "the cameras file to write");
  command.add_option("--seed", arguments.landscape.seed, "names the scene")->capture_default_str();
  command.add_option("--objects", arguments.landscape.objects, "how many")
      ->check(CLI::Range(400, 10'000'000))
      ->capture_default_str();
  command.add_option("--frames", arguments.landscape.frames, "cameras")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
}

bool writeFile(const std::string& path, std::span<const char> bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  out.close();
  if (out.good()) return true;
  std::cerr << "make_scene: " << path << ": cannot write\n";
  return false;
}

int write(const Arguments& to, const culld::scenes::Model& model,
          std::span<const culld::scenes::CameraSpec> cameras) {
  const std::vector<std::byte> glb = culld::scenes::toGlb(model);
  if (!writeFile(to.glb, {reinterpret_cast<const char*>(glb.data()), glb.size()})) {
    return kCannotWrite;
  }
  const std::string list = culld::scenes::toJson(cameras);
  if (!to.cameras.empty() && !writeFile(to.cameras, list)) return kCannotWrite;
  std::cout << to.glb << ": " << model.objectCount() << " objects, " << model.meshes.size()
            << " meshes, " << glb.size() << " bytes; " << cameras.size() << " cameras\n";
  return 0;
}

int makeRandom(const Arguments& arguments) {
  const culld::scenes::Model model =
      culld::scenes::randomModel(arguments.city.seed, arguments.random);
  const auto cameras = culld::scenes::randomCameras(
      arguments.city.seed, *culld::scenes::toSnapshot(model), arguments.city.frames);
  return write(arguments, model, cameras);
}

int makeTour(const Arguments& arguments) {
  const auto scene = culld::loadGltfFile(arguments.glb);
  if (!scene) {
    std::cerr << "make_scene: " << scene.error().message << '\n';
    return 2;
  }
  const auto cameras = culld::scenes::tourCameras(*scene.value(), arguments.tour_frames);
  const std::string list = culld::scenes::toJson(cameras);
  if (!writeFile(arguments.cameras, list)) return kCannotWrite;
  std::cout << arguments.cameras << ": " << cameras.size() << " cameras\n";
  return 0;
}

}  // namespace

int main(int argc, char** argv) try {
  Arguments arguments;
  CLI::App app("Writes generated scenes");
  app.require_subcommand(1);
  CLI::App* city = app.add_subcommand("city", "the sample city of the demo");
  CLI::App* random = app.add_subcommand("random", "a small scene that looks for trouble");
  for (CLI::App* command : {city, random}) {
    command->add_option("-o,--output", arguments.glb, "the .glb to write")->required();
    command->add_option("--cameras", arguments.cameras, "the cameras file to write");
    command->add_option("--seed", arguments.city.seed, "names the scene")->capture_default_str();
    command->add_option("--frames", arguments.city.frames, "cameras")
        ->check(CLI::Range(1, 1'000'000))
        ->capture_default_str();
  }
  city->add_option("--objects", arguments.city.objects, "how many")
      ->check(CLI::Range(1, 10'000'000))
      ->capture_default_str();
  random->add_option("--objects", arguments.random.objects, "about how many")
      ->capture_default_str();
  std::vector<std::pair<CLI::App*, MakeLandscape>> landscapes{
      {app.add_subcommand("arena", "an open field seen from its stands"), culld::scenes::arena},
      {app.add_subcommand("terrain", "sparse open country"), culld::scenes::sparseTerrain},
      {app.add_subcommand("rooms", "closed rooms with doors"), culld::scenes::closedRooms}};
  for (const auto& [command, make] : landscapes) declareLandscape(*command, arguments);
  CLI::App* tour = app.add_subcommand("cameras", "a path through a scene that exists");
  tour->add_option("SCENE", arguments.glb, "the .glb or .gltf to read")->required();
  tour->add_option("-o,--output", arguments.cameras, "the cameras file to write")->required();
  tour->add_option("--frames", arguments.tour_frames, "cameras")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (random->parsed()) return makeRandom(arguments);
  if (tour->parsed()) return makeTour(arguments);
  for (const auto& [command, make] : landscapes) {
    if (!command->parsed()) continue;
    const culld::scenes::Landscape made = make(arguments.landscape);
    return write(arguments, made.model, made.cameras);
  }
  const culld::scenes::City made = culld::scenes::generateCity(arguments.city);
  return write(arguments, made.model, made.cameras);
} catch (const std::exception& failure) {
  std::cerr << "make_scene: " << failure.what() << '\n';
  return 2;
}
