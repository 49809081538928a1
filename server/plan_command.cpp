#include "server/plan_command.h"

#include <CLI/CLI.hpp>
#include <iostream>
#include <utility>

#include "culling/culler.h"
#include "server/command_inputs.h"
#include "server/command_line.h"
#include "server/plan_report.h"

namespace culld {
namespace {

struct Options {
  std::string scene, cameras;
  bool json = false;
};

int run(const Options& o) {
  std::vector<Camera> cameras;
  if (!o.cameras.empty()) {
    auto read = readCameras(o.cameras);
    if (!read) return fail(kUsage, read.error().message);
    cameras = std::move(read).value();
  }
  const auto scene = loadScene(o.scene);
  if (!scene) return fail(kUsage, scene.error().message);
  const auto report = planReport(o.scene, scene.value(), *findMethod("auto"), cameras);
  if (!report) return fail(kFailed, o.scene + ": " + report.error().message);
  std::cout << (o.json ? report.value() : planText(report.value()));
  return kFine;
}

}  // namespace

int runPlan(std::vector<std::string> arguments) {
  Options options;
  CLI::App app("says what is used for a scene, what is left out, and why", "culld plan");
  app.add_option("SCENE", options.scene, "glTF scene, .glb or .gltf")->required();
  app.add_option("--cameras", options.cameras, "measure on these cameras too");
  app.add_flag("--json", options.json, "for programs");
  if (const auto done = parseArguments(app, std::move(arguments))) return *done;
  return run(options);
}

}  // namespace culld
