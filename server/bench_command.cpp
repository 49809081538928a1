#include "server/bench_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <sstream>
#include <utility>

#include "culling/core/simd.h"
#include "culling/planner/scene_profile.h"
#include "culling/report/bench.h"
#include "protocol/answer_file.h"
#include "protocol/id_set.h"
#include "protocol/text.h"
#include "server/backend_option.h"
#include "server/command_inputs.h"
#include "server/command_line.h"
#include "server/machine.h"

namespace culld {
namespace {

namespace fs = std::filesystem;

// What the others are compared with.
constexpr const char* kBaseline = "frustum";

struct Options {
  std::vector<std::string> scenes;
  std::string cameras, methods = "all", sizes, times_us, report, backend = "auto", simd = "auto";
  std::uint32_t repeat = 5, every = 1, samples = 4, rays = 16;
  std::uint64_t seed = 1;
  std::span<const Method* const> table;  ///< all that there are
  std::vector<const Method*> asked;      ///< to run
};

void declare(CLI::App& app, Options& o) {
  app.add_option("SCENE", o.scenes, "glTF scenes, .glb or .gltf")->required();
  app.add_option("--cameras", o.cameras,
                 "cameras file for all scenes; else X.cameras.json of X.glb");
  app.add_option(
      "--methods", o.methods,
      "all, or names with commas, also NAME:SETTING=VALUE...; auto: the planner's choice");
  app.add_option("--sizes", o.sizes, "image sizes, 640x360,1280x720; else each camera's own");
  app.add_option("--times-us", o.times_us,
                 "time limits per camera, 500,2000, in microseconds; no limit is always measured");
  app.add_option("--repeat", o.repeat, "times that each camera is answered")
      ->check(CLI::Range(1U, 10'000U));
  app.add_option("--every", o.every, "take every Nth camera")->check(CLI::Range(1U, 1'000'000U));
  app.add_option("--samples", o.samples, "truth: rays through each pixel, rounded up to a square")
      ->check(CLI::Range(1U, 1024U));
  app.add_option("--rays", o.rays, "truth: rays aimed at each object not seen so far")
      ->check(CLI::Range(0U, 1'000'000U));
  app.add_option("--seed", o.seed, "truth: of its random numbers")->check(CLI::NonNegativeNumber);
  app.add_option("--backend", o.backend, kBackendHelp);
  app.add_option("--simd", o.simd, "force a SIMD target: auto, sse4, avx2, avx3");
  app.add_option("--report", o.report, "folder for report.html, report.csv, report.json")
      ->required();
}

std::vector<std::string> splitAtCommas(const std::string& text) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, ',');) parts.push_back(part);
  return parts;
}

Result<std::chrono::nanoseconds> timeLimit(const std::string& text) {
  std::uint32_t us = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), us);
  if (error != std::errc{} || end != text.data() + text.size()) {
    return invalidInput("--times-us " + text + ": not a whole number of microseconds");
  }
  return std::chrono::nanoseconds(std::chrono::microseconds(us));
}

Result<ImageSize> imageSize(const std::string& text) {
  unsigned width = 0, height = 0;
  char rest = 0;
  const int read = std::sscanf(text.c_str(), "%5ux%5u%c", &width, &height, &rest);
  if (read != 2 || width == 0 || height == 0 || width > kMaxImageSide || height > kMaxImageSide) {
    return invalidInput("--sizes " + text + ": not WIDTHxHEIGHT");
  }
  return ImageSize{width, height};
}

Result<BenchOptions> benchOptions(const Options& o) {
  BenchOptions options;
  for (const std::string& text : splitAtCommas(o.sizes)) {
    const auto size = imageSize(text);
    if (!size) return size.error();
    options.images.push_back(size.value());
  }
  for (const std::string& text : splitAtCommas(o.times_us)) {
    const auto limit = timeLimit(text);
    if (!limit) return limit.error();
    options.limits.push_back(limit.value());
  }
  options.repeat = o.repeat;
  options.truth.lattice = static_cast<std::uint32_t>(std::ceil(std::sqrt(o.samples)));
  options.truth.rays_per_object = o.rays;
  options.truth.seed = o.seed;
  options.wire_bytes = [](std::span<const ObjectId> before, std::span<const ObjectId> now) {
    return protocol::encodeSmallest(before, now).payload.size();
  };
  return options;
}

/// The methods asked for, each once, the baseline first.
Result<std::vector<const Method*>> methodsAsked(const Options& o, ConfiguredMethods& known) {
  std::vector<std::string> names{kBaseline};
  for (const std::string& asked : splitAtCommas(o.methods)) {
    if (asked != "all") {
      names.push_back(asked);
      continue;
    }
    for (const Method* method : o.table) names.emplace_back(method->info().name);
  }
  std::vector<const Method*> methods;
  for (const std::string& name : names) {
    const auto method = known.find(name);
    if (!method) return method.error();
    if (std::find(methods.begin(), methods.end(), method.value()) == methods.end()) {
      methods.push_back(method.value());
    }
  }
  return methods;
}

std::string camerasOf(const Options& o, const std::string& scene) {
  if (!o.cameras.empty()) return o.cameras;
  return fs::path(scene).replace_extension(".cameras.json").string();
}

/// ERROR: also if there are none.
Result<std::vector<Camera>> camerasFor(const Options& o, const std::string& scene) {
  const std::string path = camerasOf(o, scene);
  auto cameras = readCameras(path);
  if (cameras && cameras.value().empty()) return invalidInput(path + ": no cameras");
  return cameras;
}

/// Reads all that will be measured, as the first scene alone may take an hour.
Result<void> tryInputs(const Options& o) {
  for (const std::string& path : o.scenes) {
    if (auto cameras = camerasFor(o, path); !cameras) return cameras.error();
    if (auto scene = loadScene(path); !scene) return scene.error();
  }
  return Done{};
}

/// The file's name, or the whole path where another scene's file is called the same.
std::string nameOf(const Options& o, const std::string& path) {
  const fs::path file = fs::path(path).filename();
  const auto same = std::count_if(o.scenes.begin(), o.scenes.end(), [&](const std::string& other) {
    return fs::path(other).filename() == file;
  });
  return protocol::oneLine(same > 1 ? path : file.string());
}

/// Every Nth of the file.
Result<void> addCameras(const Options& o, const std::string& path, BenchScene& scene) {
  const auto cameras = camerasFor(o, path);
  if (!cameras) return cameras.error();
  for (std::size_t i = 0; i < cameras.value().size(); i += o.every) {
    scene.cameras.push_back(cameras.value()[i]);
    scene.numbers.push_back(i);
  }
  return Done{};
}

/// A method that is not for the scene is noted.
Result<void> addMethods(const Options& o, BenchScene& scene) {
  const SceneProfile profile = profileScene(*scene.scene);
  for (std::size_t i = 0; i < o.asked.size(); ++i) {
    const std::string name(o.asked[i]->info().name);
    if (auto fits = o.asked[i]->accepts(profile); fits) {
      scene.methods.push_back({name, o.asked[i], i});
    } else if (name == kBaseline) {
      return fits.error();
    } else {
      scene.refused.push_back({name, fits.error().message});
    }
  }
  return Done{};
}

Result<SceneFigures> measure(const Options& o, const BenchOptions& options,
                             const std::string& path) {
  BenchScene scene;
  scene.name = nameOf(o, path);
  if (auto added = addCameras(o, path, scene); !added) return added.error();
  auto loaded = loadScene(path);
  if (!loaded) return loaded.error();
  scene.scene = std::move(loaded).value();
  if (auto added = addMethods(o, scene); !added) {
    return Error{added.error().code, path + ": " + added.error().message};
  }
  ProgressBar bar("bench " + scene.name);
  BenchOptions watched = options;
  watched.progress = [&bar](std::size_t done, std::size_t total) { bar.show(done, total); };
  auto figures = benchScene(scene, watched);
  if (!figures) return Error{figures.error().code, path + ": " + figures.error().message};
  return figures;
}

/// GUARANTEES: a reader finds the report before or the one after, whole.
Result<void> replaceFile(const fs::path& path, const std::string& text) {
  const std::string part = path.string() + ".part";
  if (auto written = protocol::writeTextFile(part, text); !written) {
    return Error{ErrorCode::kIo, written.error().message};
  }
  std::error_code failure;
  fs::rename(part, path, failure);
  if (failure) return Error{ErrorCode::kIo, path.string() + ": " + failure.message()};
  return Done{};
}

Result<void> write(const BenchReport& report, const std::string& folder) {
  const fs::path to(folder);
  const std::pair<const char*, std::string> files[] = {{"report.csv", benchCsv(report)},
                                                       {"report.json", benchJson(report)},
                                                       {"report.html", benchHtml(report)}};
  for (const auto& [name, text] : files) {
    if (auto written = replaceFile(to / name, text); !written) return written;
  }
  return Done{};
}

BenchFacts factsOf(const Options& o, const std::string& command) {
  BenchFacts facts = machineFacts();
  facts.emplace_back("command", command);
  facts.emplace_back("load at the start", machineLoad());
  const auto lattice = static_cast<std::uint32_t>(std::ceil(std::sqrt(o.samples)));
  facts.emplace_back("truth", std::to_string(lattice * lattice) + " rays a pixel, " +
                                  std::to_string(o.rays) + " aimed at each object not seen, seed " +
                                  std::to_string(o.seed));
  facts.emplace_back("backend", backendInUse());
  facts.emplace_back("repetitions", std::to_string(o.repeat) + ", the methods in turn");
  return facts;
}

/// As a shell reads it back.
std::string quoted(const std::string& argument) {
  const bool plain = !argument.empty() && argument.find_first_not_of(
                                              "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                              "0123456789-_./,=:@%+") == std::string::npos;
  if (plain) return argument;
  std::string out = "'";
  for (const char c : argument) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

int say(const BenchReport& report) {
  std::cout << report.verdict() << '\n' << benchText(report);
  return report.breaches().empty() ? kFine : kFailed;
}

int run(Options& o, const std::string& command) {
  ConfiguredMethods known(o.table);
  auto asked = methodsAsked(o, known);
  if (!asked) return fail(kUsage, asked.error().message);
  o.asked = std::move(asked).value();
  const auto options = benchOptions(o);
  if (!options) return fail(kUsage, options.error().message);
  if (auto forced = forceSimdTarget(o.simd); !forced) return fail(kUsage, forced.error().message);
  if (auto opened = openBackendNamed(o.backend); !opened) {
    return fail(exitCodeOf(opened.error()), opened.error().message);
  }
  std::error_code error;
  fs::create_directories(o.report, error);
  if (error) return fail(kDisk, o.report + ": " + error.message());
  if (auto readable = tryInputs(o); !readable) return fail(kUsage, readable.error().message);

  BenchReport report;
  report.facts = factsOf(o, command);
  for (const std::string& path : o.scenes) {
    auto figures = measure(o, options.value(), path);
    if (!figures) {
      const bool input = figures.error().code != ErrorCode::kUnavailable;
      const int status = fail(input ? kUsage : kFailed, figures.error().message);
      return report.breaches().empty() ? status : say(report);
    }
    report.scenes.push_back(std::move(figures).value());
    // After each scene: whoever is interrupted keeps what is done.
    if (auto written = write(report, o.report); !written) {
      return fail(kDisk, written.error().message);
    }
  }
  return say(report);
}

}  // namespace

int runBench(std::vector<std::string> arguments, std::span<const Method* const> methods) {
  std::string command = "culld bench";
  for (const std::string& argument : arguments) command += " " + quoted(argument);
  Options options;
  options.table = methods;
  CLI::App app("error against run time: scenes x methods x settings", "culld bench");
  declare(app, options);
  if (const auto done = parseArguments(app, std::move(arguments))) return *done;
  return run(options, command);
}

}  // namespace culld
