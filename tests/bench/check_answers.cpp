// check_answers: holds an answers file against the oracle, camera by camera. Exit code 1 if an
// object that can be seen was not answered.
#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "tests/bench/checked_frame.h"

namespace culld::bench {
namespace {

struct Arguments {
  std::string scene, cameras, answers, pictures, json;
  std::uint32_t samples = 4, rays = 16, every = 1, poses = OracleOptions{}.poses;
};

int fail(const std::string& message, int code = 2) {
  std::fprintf(stderr, "check_answers: %s\n", message.c_str());
  return code;
}

void printHead(const Inputs& inputs) {
  std::printf("%s: %zu objects, %llu triangles; method %s, guarantee %s\n\n", inputs.name.c_str(),
              inputs.scene->objectCount(),
              static_cast<unsigned long long>(inputs.scene->triangleCount()), inputs.method.c_str(),
              inputs.guarantee.c_str());
  std::printf("%6s %10s %9s %9s %9s %7s %7s %8s %13s %13s %8s\n", "camera", "in frustum",
              "answered", "visible", "sub-pixel", "missed", "missed", "excess", "triangles in",
              "triangles", "oracle");
  std::printf("%6s %10s %9s %9s %9s %7s %7s %8s %13s %13s %8s\n", "", "", "", "", "", "", "sub-px",
              "", "the frustum", "answered", "s");
}

void printFrame(const CheckedFrame& f) {
  std::printf("%6zu %10zu %9zu %9zu %9zu %7zu %7zu %8.3f %13llu %13llu %8.2f\n", f.camera,
              f.in_frustum, f.answered, f.visible, f.visible_subpixel, f.missed, f.missed_subpixel,
              f.excess(), static_cast<unsigned long long>(f.frustum_triangles),
              static_cast<unsigned long long>(f.answered_triangles), f.oracle_s);
  for (const MissedObject& m : f.examples) {
    std::printf("       missed: node %u instance %u, %.2f px\n", m.node, m.instance,
                static_cast<double>(m.pixels));
  }
  std::fflush(stdout);
}

template <typename T>
double mean(const std::vector<CheckedFrame>& frames, T CheckedFrame::*field) {
  double sum = 0.0;
  for (const CheckedFrame& f : frames) sum += static_cast<double>(f.*field);
  return frames.empty() ? 0.0 : sum / static_cast<double>(frames.size());
}

template <typename T>
T total(const std::vector<CheckedFrame>& frames, T CheckedFrame::*field) {
  T sum{};
  for (const CheckedFrame& f : frames) sum += f.*field;
  return sum;
}

/// What the oracle itself may have missed, over all cameras.
void printUnfound(const std::vector<CheckedFrame>& frames) {
  double next_round = 0.0, forever = 0.0, next_pose = 0.0;
  bool moving = false;
  for (const CheckedFrame& f : frames) {
    next_round += f.truth.unfound_by_rays.byOneMoreTry();
    forever += f.truth.unfound_by_rays.byAnyNumber();
    next_pose += f.truth.unfound_by_poses.byOneMoreTry();
    moving = moving || f.truth.poses > 1;
  }
  std::printf(
      "  visible, yet unfound      %12.1f   by estimate, over all cameras; %u more rays at each\n"
      "                                           unseen object would find %.1f of them\n",
      forever, kAimedRaysPerRound, next_round);
  if (moving) {
    std::printf(
        "                            %12.1f   more by one more pose within each motion bound\n",
        next_pose);
  }
}

void printSummary(const Inputs& inputs, const std::vector<CheckedFrame>& frames) {
  const double in_frustum = mean(frames, &CheckedFrame::in_frustum);
  const double answered = mean(frames, &CheckedFrame::answered);
  const double visible = mean(frames, &CheckedFrame::visible);
  const double drawn = mean(frames, &CheckedFrame::answered_triangles);
  const double all = mean(frames, &CheckedFrame::frustum_triangles);
  std::printf("\n%zu cameras checked; per camera, on average:\n", frames.size());
  std::printf("  objects in the scene      %12zu\n", inputs.scene->objectCount());
  std::printf("  objects in the frustum    %12.1f\n", in_frustum);
  std::printf("  objects answered          %12.1f\n", answered);
  std::printf("  objects truly visible     %12.1f   (%.1f of them through gaps below a pixel)\n",
              visible, mean(frames, &CheckedFrame::visible_subpixel));
  std::printf("  triangles in the frustum  %12.0f   what drawing everything there would cost\n",
              all);
  std::printf("  triangles answered        %12.0f   %.1f times fewer\n", drawn,
              drawn > 0.0 ? all / drawn : 0.0);
  std::printf("  visible objects missed    %12zu   over all cameras (%zu of them below a pixel)\n",
              total(frames, &CheckedFrame::missed) + total(frames, &CheckedFrame::missed_subpixel),
              total(frames, &CheckedFrame::missed_subpixel));
  printUnfound(frames);
}

nlohmann::json asJson(const UnfoundEstimate& estimate) {
  return {{"tries", estimate.tries},
          {"found_once", estimate.found_once},
          {"not_found", estimate.not_found},
          {"by_one_more_try", estimate.byOneMoreTry()},
          {"by_any_number", estimate.byAnyNumber()}};
}

nlohmann::json asJson(const CheckedFrame& f) {
  return {{"camera", f.camera},
          {"in_frustum", f.in_frustum},
          {"answered", f.answered},
          {"visible", f.visible},
          {"visible_subpixel", f.visible_subpixel},
          {"missed", f.missed},
          {"missed_subpixel", f.missed_subpixel},
          {"missed_px", f.missed_px},
          {"ties_left_out", f.ties_left_out},
          {"frustum_triangles", f.frustum_triangles},
          {"answered_triangles", f.answered_triangles},
          {"oracle_seconds", f.oracle_s},
          {"oracle_rays", f.rays},
          {"oracle_poses", f.truth.poses},
          {"unfound_by_rays", asJson(f.truth.unfound_by_rays)},
          {"unfound_by_poses", asJson(f.truth.unfound_by_poses)}};
}

bool writeJson(const std::string& path, const Inputs& inputs,
               const std::vector<CheckedFrame>& frames) {
  nlohmann::json list = nlohmann::json::array();
  for (const CheckedFrame& frame : frames) list.push_back(asJson(frame));
  const nlohmann::json all = {
      {"method", inputs.method},
      {"guarantee", inputs.guarantee},
      {"scene",
       {{"objects", inputs.scene->objectCount()}, {"triangles", inputs.scene->triangleCount()}}},
      {"missed", total(frames, &CheckedFrame::missed)},
      {"missed_subpixel", total(frames, &CheckedFrame::missed_subpixel)},
      {"frames", std::move(list)}};
  std::ofstream file(path);
  file << all.dump(1) << '\n';
  file.close();
  return !file.fail();
}

int check(const Arguments& arguments) {
  const auto inputs = readInputs(arguments.scene, arguments.cameras, arguments.answers);
  if (!inputs) return fail(inputs.error().message);
  const auto oracle = Oracle::build(inputs.value().scene);
  if (!oracle) return fail(oracle.error().message, 1);
  OracleOptions options;
  options.lattice = static_cast<std::uint32_t>(std::ceil(std::sqrt(arguments.samples)));
  options.rays_per_object = arguments.rays;
  options.poses = arguments.poses;
  std::error_code error;
  if (!arguments.pictures.empty()) std::filesystem::create_directories(arguments.pictures, error);
  if (error) return fail(arguments.pictures + ": " + error.message(), 74);

  printHead(inputs.value());
  std::vector<CheckedFrame> frames;
  for (std::size_t i = 0; i < inputs.value().frames.size(); i += arguments.every) {
    const AnsweredFrame& answered = inputs.value().frames[i];
    auto frame = checkFrame(inputs.value(), answered, *oracle.value(), options);
    if (!frame) return fail(frame.error().message, 1);
    printFrame(frame.value());
    if (!arguments.pictures.empty()) {
      const auto drawn =
          drawFrame(inputs.value(), answered, frame.value(), *oracle.value(), arguments.pictures);
      if (!drawn) return fail(drawn.error().message, 74);
    }
    frames.push_back(std::move(frame).value());
  }
  printSummary(inputs.value(), frames);
  if (!arguments.json.empty() && !writeJson(arguments.json, inputs.value(), frames)) {
    return fail(arguments.json + ": cannot write", 74);
  }
  const bool sound = total(frames, &CheckedFrame::missed) == 0 &&
                     total(frames, &CheckedFrame::missed_subpixel) == 0;
  return sound ? 0 : 1;
}

}  // namespace
}  // namespace culld::bench

int main(int argc, char** argv) try {
  culld::bench::Arguments arguments;
  CLI::App app{"Holds an answers file against what rays see. Exit code 1: something was missed."};
  app.add_option("scene", arguments.scene, "the scene's .glb or .gltf")->required();
  app.add_option("--cameras", arguments.cameras, "cameras file")->required();
  app.add_option("--answers", arguments.answers, "answers file, from culld cull or cullctl cull")
      ->required();
  app.add_option("--samples", arguments.samples, "rays through each pixel (rounded up to a square)")
      ->check(CLI::Range(1U, 1024U));
  app.add_option("--rays", arguments.rays, "rays aimed at each object not seen so far")
      ->check(CLI::Range(0U, 100'000U));
  app.add_option("--poses", arguments.poses, "further poses within a camera's motion bound");
  app.add_option("--every", arguments.every, "check each N-th frame only")
      ->check(CLI::PositiveNumber);
  app.add_option("--pictures", arguments.pictures, "draw each checked frame into this directory");
  app.add_option("--json", arguments.json, "write the figures to this file");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  return culld::bench::check(arguments);
} catch (const std::exception& failure) {
  return culld::bench::fail(failure.what());
}
