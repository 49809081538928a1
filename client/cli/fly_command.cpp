#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "client/cli/camera_run.h"
#include "client/cli/commands.h"
#include "client/cli/numbers.h"
#include "protocol/text.h"

namespace culld::client {
namespace {

using nlohmann::json;

struct Measured {
  std::size_t in_frustum = 0, answered = 0, bytes = 0;
  double server_ms = 0.0, round_trip_ms = 0.0;
  bool delta = false;
};

void printHead(const CameraRun& run) {
  const SceneInfo scene = run.scene();
  std::printf("%s: %u objects, %llu triangles; method %s, %s\n", scene.name.c_str(), scene.objects,
              static_cast<unsigned long long>(scene.triangles), run.view().method().c_str(),
              protocol::guaranteeName(run.view().guarantee()).c_str());
  std::printf("%6s %9s %11s %9s %10s %13s %9s %9s %9s %9s\n", "frame", "objects", "in frustum",
              "answered", "server ms", "round trip ms", "bytes", "seen", "kept", "missed px");
}

bool tellsSeen(const Frame& frame) { return frame.seen_count + frame.kept_count > 0; }

/// "<=" before a bound, "~" before an estimate.
std::string missedPx(const Frame& frame) {
  std::ostringstream text;
  text << (frame.proven ? "<=" : "~") << frame.missed_px;
  return text.str();
}

Result<void> printFrame(std::size_t number, const Frame& frame, const Measured& m) {
  const bool tells = tellsSeen(frame);
  const std::string seen = tells ? std::to_string(frame.seen_count) : "-";
  const std::string kept = tells ? std::to_string(frame.kept_count) : "-";
  std::printf("%6zu %9u %11zu %9zu %10.3f %13.3f %9zu %9s %9s %9s%s%s%s%s\n", number,
              frame.scene_objects, m.in_frustum, m.answered, m.server_ms, m.round_trip_ms, m.bytes,
              seen.c_str(), kept.c_str(), missedPx(frame).c_str(), m.delta ? " (change)" : "",
              frame.out_of_budget ? " (out of time)" : "", frame.made_by.empty() ? "" : " by ",
              protocol::oneLine(frame.made_by).c_str());
  return protocol::flushStdout();
}

template <typename Field>
auto fieldOf(const std::vector<Measured>& all, Field Measured::*field) {
  std::vector<Field> values;
  values.reserve(all.size());
  for (const Measured& m : all) values.push_back(m.*field);
  return values;
}

void printSummary(const std::vector<Measured>& all) {
  const auto server = fieldOf(all, &Measured::server_ms);
  const auto trip = fieldOf(all, &Measured::round_trip_ms);
  const auto bytes = fieldOf(all, &Measured::bytes);
  std::printf("%zu frames, medians: %zu in frustum, %zu answered\n", all.size(),
              percentile(fieldOf(all, &Measured::in_frustum), 50),
              percentile(fieldOf(all, &Measured::answered), 50));
  std::printf("server time: median %.3f ms, p95 %.3f ms; round trip: median %.3f ms, p95 %.3f ms\n",
              percentile(server, 50), percentile(server, 95), percentile(trip, 50),
              percentile(trip, 95));
  std::printf("bytes a frame: median %zu, p95 %zu\n", percentile(bytes, 50), percentile(bytes, 95));
}

json jsonOf(std::size_t camera, const Frame& frame, const Measured& m) {
  const bool tells = tellsSeen(frame);
  return {{"camera", camera},
          {"objects", frame.scene_objects},
          {"in_frustum", m.in_frustum},
          {"answered", m.answered},
          {"seen", tells ? json(frame.seen_count) : json()},
          {"kept", tells ? json(frame.kept_count) : json()},
          {"missed_px", frame.missed_px},
          {"proven", frame.proven},
          {"out_of_budget", frame.out_of_budget},
          {"bytes", m.bytes},
          {"delta", m.delta},
          {"server_seconds", m.server_ms * 1e-3},
          {"round_trip_seconds", m.round_trip_ms * 1e-3},
          {"method", frame.method},
          {"made_by", frame.made_by},
          {"guarantee", protocol::guaranteeName(frame.guarantee)},
          {"objects_visible", frame.visible}};
}

Measured measure(const Frame& frame, std::chrono::steady_clock::duration round_trip) {
  Measured m;
  m.answered = frame.visible.size();
  m.bytes = frame.wire_bytes;
  m.server_ms = static_cast<double>(frame.stats.cull_ns) * 1e-6;
  m.round_trip_ms = std::chrono::duration<double, std::milli>(round_trip).count();
  m.delta = frame.delta;
  return m;
}

int writeJson(const std::string& path, const json& frames) {
  const std::string text = frames.dump(-1, ' ', false, json::error_handler_t::replace) + '\n';
  const auto written = protocol::writeTextFile(path, text);
  return written ? kFine : fail(kDisk, written.error().message);
}

}  // namespace

int runFly(const Server& server, const FlyArguments& arguments) {
  CameraRun run;
  if (const int code = run.start(server, arguments.cull); code != kFine) return code;
  printHead(run);
  std::vector<Measured> all;
  json frames = json::array();
  do {
    for (std::size_t i = 0; i < run.cameras().size(); ++i) {
      const auto start = std::chrono::steady_clock::now();
      const FramePtr frame = run.cull(i);
      if (frame == nullptr) return run.exitCode();
      Measured m = measure(*frame, std::chrono::steady_clock::now() - start);
      const auto in_frustum = run.inFrustum(i);
      if (!in_frustum) return fail(in_frustum.error());
      m.in_frustum = in_frustum.value();
      if (const auto printed = printFrame(i, *frame, m); !printed) {
        return fail(kDisk, printed.error().message);
      }
      if (!arguments.loop) all.push_back(m);
      if (!arguments.json_output.empty()) frames.push_back(jsonOf(i, *frame, m));
    }
  } while (arguments.loop && !run.cameras().empty());
  printSummary(all);
  if (const int code = run.finish(); code != kFine) return code;
  return arguments.json_output.empty() ? kFine : writeJson(arguments.json_output, frames);
}

}  // namespace culld::client
