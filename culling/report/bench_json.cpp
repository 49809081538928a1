#include <nlohmann/json.hpp>

#include "culling/report/bench_summary.h"

namespace culld {
namespace {

using Json = nlohmann::ordered_json;
using report::RunSummary;

Json orNull(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

/// One list per figure: shorter than an object per camera, and easier to plot.
template <typename Items, typename Get>
Json listOf(const Items& items, Get get) {
  Json list = Json::array();
  for (const auto& item : items) list.push_back(get(item));
  return list;
}

Json summaryJson(const RunSummary& sum) {
  return {{"missed", sum.missed},
          {"missed_subpixel", sum.missed_subpixel},
          {"missed_px", sum.missed_px},
          {"lossy",
           {{"answers", sum.lossy},
            {"said_px", sum.said_px},
            {"missed_px", sum.lossy_missed_px},
            {"exceeded", sum.exceeded}}},
          {"in_frustum", sum.in_frustum},
          {"visible", sum.visible},
          {"answered", sum.answered},
          {"excess", orNull(sum.excess)},
          {"culled_share", orNull(sum.culled_share)},
          {"time_us", {{"low", sum.low_us}, {"mean", sum.mean_us}, {"high", sum.high_us}}},
          {"cameras_us",
           {{"min", sum.cameras_us.min},
            {"median", sum.cameras_us.median},
            {"p95", sum.cameras_us.p95},
            {"max", sum.cameras_us.max}}},
          {"relative_time", orNull(sum.relative)},
          {"relative_time_min", orNull(sum.relative_min)},
          {"answer_bytes", sum.answer_bytes},
          {"change_bytes", sum.change_bytes},
          {"out_of_budget", sum.out_of_budget},
          {"stages",
           {{"left_out_by_frustum", sum.outside},
            {"left_out_by_occlusion", sum.occluded},
            {"occlusion_extra_us", sum.extra_us}}},
          {"work",
           {{"us", sum.work_us},
            {"relative", orNull(sum.relative_work)},
            {"nodes_visited", sum.nodes_visited},
            {"tested", sum.tested},
            {"plane_tests", sum.plane_tests},
            {"depth_comparisons", sum.depth_comparisons},
            {"occluders_drawn", sum.occluders_drawn},
            {"triangles_drawn", sum.triangles_drawn}}}};
}

Json runJson(const SceneFigures& scene, const BenchRun& run) {
  const auto& cameras = run.cameras;
  Json json = {{"method", scene.methods[run.method].name},
               {"setting", scene.settings[run.setting].name()},
               {"breaches", run.breaches},
               {"first_breach", run.first_breach ? Json(run.first_breach->line()) : Json(nullptr)},
               {"made_by", run.made_by},
               {"view_bytes", run.view_bytes}};
  json.update(summaryJson(report::summaryOf(scene, run)));
  json["cameras"] = {
      {"answered", listOf(cameras, [](const auto& c) { return c.answered; })},
      {"missed", listOf(cameras, [](const auto& c) { return c.missed; })},
      {"missed_subpixel", listOf(cameras, [](const auto& c) { return c.missed_subpixel; })},
      {"missed_px", listOf(cameras, [](const auto& c) { return c.missed_px; })},
      {"said_px", listOf(cameras, [](const auto& c) { return orNull(c.said_px); })},
      {"us_min", listOf(cameras, [](const auto& c) { return c.time_us.min; })},
      {"us_median", listOf(cameras, [](const auto& c) { return c.time_us.median; })},
      {"us_p95", listOf(cameras, [](const auto& c) { return c.time_us.p95; })},
      {"us_max", listOf(cameras, [](const auto& c) { return c.time_us.max; })},
      {"answer_bytes", listOf(cameras, [](const auto& c) { return c.answer_bytes; })}};
  return json;
}

Json methodJson(const MethodFigures& method) {
  return {{"name", method.name},
          {"source", method.source},
          {"needs", method.needs},
          {"guarantee", std::string(guaranteeName(method.guarantee))},
          {"prepare_ms", method.prepare_ms},
          {"prepared_bytes", method.prepared_bytes}};
}

Json truthJson(const std::vector<TruthFigures>& truth) {
  return {{"camera", listOf(truth, [](const auto& t) { return t.camera; })},
          {"in_frustum", listOf(truth, [](const auto& t) { return t.in_frustum; })},
          {"visible", listOf(truth, [](const auto& t) { return t.visible; })},
          {"visible_subpixel", listOf(truth, [](const auto& t) { return t.subpixel; })},
          {"rays", listOf(truth, [](const auto& t) { return t.rays; })},
          {"unfound_by_one_more_round", listOf(truth, [](const auto& t) { return t.unfound; })}};
}

Json sceneJson(const SceneFigures& scene) {
  Json json = {{"name", scene.name},           {"objects", scene.objects},
               {"triangles", scene.triangles}, {"scene_bytes", scene.scene_bytes},
               {"repetitions", scene.repeat},  {"methods", listOf(scene.methods, methodJson)},
               {"refused", Json::object()},    {"truth", Json::array()},
               {"runs", Json::array()}};
  for (const RefusedMethod& refused : scene.refused) json["refused"][refused.name] = refused.why;
  for (std::size_t i = 0; i < scene.truths.size(); ++i) {
    Json truth = truthJson(scene.truths[i]);
    const auto& image = scene.settings[i * scene.limits].image;
    truth["image"] = image ? Json({image->width_px, image->height_px}) : Json(nullptr);
    json["truth"].push_back(std::move(truth));
  }
  for (const BenchRun& run : scene.runs) json["runs"].push_back(runJson(scene, run));
  return json;
}

}  // namespace

std::string benchJson(const BenchReport& report) {
  Json json = {{"verdict", report.verdict()},
               {"guarantees_held", report.breaches().empty()},
               {"breaches", listOf(report.breaches(), [](const auto& b) { return b.line(); })}};
  for (const auto& [name, value] : report.facts) json["facts"][name] = value;
  json["scenes"] = listOf(report.scenes, sceneJson);
  using Handler = nlohmann::detail::error_handler_t;  // file names may be no UTF-8
  return json.dump(-1, ' ', false, Handler::replace) + '\n';
}

}  // namespace culld
