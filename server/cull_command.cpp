#include "server/cull_command.h"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <utility>

#include "culling/core/simd.h"
#include "culling/culler.h"
#include "protocol/answer_file.h"
#include "server/backend_option.h"
#include "server/command_inputs.h"
#include "server/command_line.h"
#include "server/scene.h"
#include "server/translate.h"

namespace culld {
namespace {

using server::SceneVersion;
using server::toEngine;
using server::toWire;

struct Options {
  std::string scene, cameras, output;
  std::string method = "auto", guarantee = "conservative", backend = "auto", simd = "auto";
  protocol::Demand demand;
  protocol::ImageSize image;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("SCENE", o.scene, "glTF scene, .glb or .gltf")->required();
  app.add_option("--cameras", o.cameras, "cameras file, a JSON list")->required();
  app.add_option("--method", o.method,
                 "culling method, also NAME:SETTING=VALUE...; auto: the best that fits the scene");
  app.add_option("--guarantee", o.guarantee, "conservative, hole, sampled or approximate");
  app.add_option("--hole-px", o.demand.hole_px, "side of the hole accepted, with --guarantee hole");
  app.add_option("--accept-missed-px", o.demand.accepted_missed_px,
                 "visible pixels that may be missed");
  app.add_option("--time-us", o.demand.time_us, "time per camera, in microseconds; 0: no limit");
  app.add_option("--width", o.image.width_px, "image width, for cameras that do not say");
  app.add_option("--height", o.image.height_px, "image height, for cameras that do not say");
  app.add_option("--backend", o.backend, kBackendHelp);
  app.add_option("--simd", o.simd, "force a SIMD target: auto, sse4, avx2, avx3");
  app.add_option("-o,--output", o.output, "answers file to write")->required();
}

Result<Demand> demandOf(const Options& o) {
  protocol::Demand demand = o.demand;
  const auto guarantee = protocol::guaranteeNamed(o.guarantee);
  if (!guarantee) return invalidInput(guarantee.error().message);
  demand.guarantee = guarantee.value();
  return toEngine(demand);
}

std::vector<protocol::ObjectName> namesOf(const SceneSnapshot& scene) {
  std::vector<protocol::ObjectName> names(scene.objectCount());
  for (std::size_t i = 0; i < names.size(); ++i) {
    const Instance& instance = scene.instance(static_cast<ObjectId>(i));
    names[i] = {instance.node, instance.instance_number};
  }
  return names;
}

protocol::AnswerFrame frameOf(std::size_t camera, const Answer& answer) {
  protocol::AnswerFrame frame;
  frame.camera = camera;
  frame.visible = answer.visible;
  frame.seen = answer.seen;
  frame.seconds = std::chrono::duration<double>(answer.stats.time).count();
  frame.missed_px = answer.missed_px;
  frame.proven = answer.proven;
  frame.out_of_budget = answer.out_of_budget;
  frame.guarantee = toWire(answer.guarantee);
  frame.made_by = answer.made_by;
  return frame;
}

/// The cameras one after another, as one client would send them.
int cullAll(const Options& o, const Demand& demand, const std::vector<Camera>& cameras,
            const Culler& culler, protocol::AnswerHeader header, const SceneSnapshot& scene) {
  protocol::AnswerWriter writer(namesOf(scene));
  ViewState view;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    const Answer answer = culler.cull(cameras[i], demand, view);
    header.guarantee = std::max(header.guarantee, toWire(answer.guarantee));  // the weakest
    if (!protocol::satisfies(toWire(answer.guarantee), toWire(demand.guarantee))) {
      return fail(kFailed, o.cameras + ": camera " + std::to_string(i) + ": the answer is " +
                               std::string(guaranteeName(answer.guarantee)) + ", not " +
                               o.guarantee);
    }
    if (const auto added = writer.add(frameOf(i, answer)); !added) {
      return fail(kFailed, o.cameras + ": " + added.error().message);
    }
  }
  const auto written = protocol::writeTextFile(o.output, writer.text(header));
  return written ? kFine : fail(kDisk, written.error().message);
}

int run(const Options& o) {
  const auto demand = demandOf(o);
  if (!demand) return fail(kUsage, demand.error().message);
  if (const auto forced = forceSimdTarget(o.simd); !forced) {
    return fail(kUsage, forced.error().message);
  }
  if (const auto opened = openBackendNamed(o.backend); !opened) {
    return fail(exitCodeOf(opened.error()), opened.error().message);
  }
  ConfiguredMethods methods(allMethods());
  if (const auto known = methods.find(o.method); !known) {
    return fail(kUsage, known.error().message);  // before a large scene is loaded in vain
  }
  const auto cameras = readCameras(o.cameras, o.image);
  if (!cameras) return fail(kUsage, cameras.error().message);
  const auto scene = loadScene(o.scene);
  if (!scene) return fail(kUsage, scene.error().message);

  const SceneVersion version(methods.all(), scene.value(), 1);
  const auto method = version.method(o.method);
  if (!method) return fail(kFailed, o.scene + ": " + method.error().message);
  const MethodInfo info = method.value()->info();
  const protocol::AnswerHeader header{std::string(info.name), toWire(info.guarantee),
                                      scene.value()->objectCount(), scene.value()->triangleCount()};
  if (!protocol::satisfies(header.guarantee, toWire(demand.value().guarantee))) {
    return fail(kUsage, "method " + header.method + ": gives " +
                            protocol::guaranteeName(header.guarantee) + " answers, not the " +
                            o.guarantee + " ones demanded");
  }
  const auto culler = version.culler(*method.value());
  if (!culler) return fail(kFailed, o.scene + ": " + culler.error().message);
  return cullAll(o, demand.value(), cameras.value(), *culler.value(), header, *scene.value());
}

}  // namespace

int runCull(std::vector<std::string> arguments) {
  Options options;
  CLI::App app("answers a file of cameras on one scene", "culld cull");
  declare(app, options);
  if (const auto done = parseArguments(app, std::move(arguments))) return *done;
  return run(options);
}

}  // namespace culld
