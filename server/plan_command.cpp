#include "server/plan_command.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <utility>

#include "culling/culler.h"
#include "culling/planner/depth_complexity.h"
#include "culling/report/depth_picture.h"
#include "server/command_inputs.h"
#include "server/command_line.h"
#include "server/plan_report.h"

namespace culld {
namespace {

struct Options {
  std::string scene, cameras, depth_picture;
  bool json = false;
};

constexpr std::uint32_t kPictureWidthPx = 1280;

/// What the first view sees.
Result<void> drawDepthOf(const Options& o, const SceneSnapshot& scene,
                         std::span<const Camera> cameras) {
  const std::vector<Camera> views = depthViews(scene, cameras);
  if (views.empty()) return Error{ErrorCode::kUnsupported, "nothing to be seen in the scene"};
  const Camera& view = views.front();
  const std::uint32_t height_px = std::max(
      1U,
      static_cast<std::uint32_t>(std::uint64_t{kPictureWidthPx} * view.height_px / view.width_px));
  const auto depth = depthComplexity(scene, view, kPictureWidthPx, height_px);
  return drawDepth({depth.surfaces, kPictureWidthPx, height_px, o.scene}, o.depth_picture);
}

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
  if (!o.depth_picture.empty()) {
    const auto drawn = drawDepthOf(o, *scene.value(), cameras);
    if (!drawn)
      return fail(drawn.error().code == ErrorCode::kIo ? kDisk : kFailed, drawn.error().message);
  }
  std::cout << (o.json ? report.value() : planText(report.value()));
  return kFine;
}

}  // namespace

int runPlan(std::vector<std::string> arguments) {
  Options options;
  CLI::App app("says what is used for a scene, what is left out, and why", "culld plan");
  app.add_option("SCENE", options.scene, "glTF scene, .glb or .gltf")->required();
  app.add_option("--cameras", options.cameras, "measure on these cameras too");
  app.add_option("--depth-picture", options.depth_picture,
                 "a PNG: surfaces behind each other in each pixel of the first camera");
  app.add_flag("--json", options.json, "for programs");
  if (const auto done = parseArguments(app, std::move(arguments))) return *done;
  return run(options);
}

}  // namespace culld
