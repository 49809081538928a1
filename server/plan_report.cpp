#include "server/plan_report.h"

#include <algorithm>
#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "culling/core/prices.h"
#include "culling/planner/auto_method.h"
#include "culling/planner/depth_complexity.h"
#include "culling/planner/sample_views.h"
#include "culling/planner/scene_shape.h"
#include "culling/spatial/wide_bvh.h"

namespace culld {
namespace {

using nlohmann::json;

constexpr std::size_t kRounds = 5;  ///< along the cameras
constexpr std::size_t kDepthViews = 4, kMostDepth = 64;
constexpr std::uint32_t kDepthWidthPx = 320, kDepthHeightPx = 180;

double us(std::chrono::nanoseconds time) {
  return std::chrono::duration<double, std::micro>(time).count();
}

json sceneJson(const SceneSnapshot& scene, const SceneProfile& profile) {
  const SceneShape shape = shapeOf(scene);
  return {{"objects", profile.objects},
          {"triangles", profile.triangles},
          {"blocking_triangles", profile.blocking_triangles},
          {"bytes", scene.bytes()},
          {"edits", scene.version() - 1},
          {"size_m", {{"p10", shape.small_m}, {"median", shape.median_m}, {"p90", shape.large_m}}},
          {"triangles_per_object", shape.triangles_per_object},
          {"depth_complexity", shape.depth_complexity},
          {"occluder_potential", shape.occluder_potential},
          {"closedness", shape.closedness},
          {"upright", shape.upright}};
}

double mean(std::span<const PlannedView> views, std::uint32_t PlannedView::*part) {
  double sum = 0.0;
  for (const PlannedView& view : views) sum += view.*part;
  return views.empty() ? 0.0 : sum / static_cast<double>(views.size());
}

/// What a stage brings beside what answers where it is off.
json stageJson(const Plan& plan, const PlannedStage& stage) {
  const double without = mean(stage.views, &PlannedView::base_visible);
  return {{"method", std::string(stage.method->info().name)},
          {"sampled", stage.views.size()},
          {"in_frustum", mean(stage.views, &PlannedView::in_frustum)},
          {"answered_without", without},
          {"answered_with", mean(stage.views, &PlannedView::visible)},
          {"work_us", us(stage.meanWork())},
          {"pays_in", stage.paysIn()},
          {"gain_us", us(stage.meanGain())},
          {"gain_at_most_us", us(plan.object_price) * without}};
}

json viewsJson(const Plan& plan) {
  json stages = json::array();
  for (const PlannedStage& stage : plan.stages) stages.push_back(stageJson(plan, stage));
  return {{"counted_work_ms", 1e-3 * us(plan.planning_work)}, {"stages", std::move(stages)}};
}

/// Over all pixels of all views.
json depthJson(const SceneSnapshot& scene, std::span<const Camera> cameras) {
  const std::vector<Camera> views = depthViews(scene, cameras);
  DepthComplexity all;
  for (const Camera& view : views) {
    const auto one = depthComplexity(scene, view, kDepthWidthPx, kDepthHeightPx);
    all.surfaces.insert(all.surfaces.end(), one.surfaces.begin(), one.surfaces.end());
  }
  std::vector<std::uint64_t> pixels = all.histogram();
  while (pixels.size() > kMostDepth + 1) {  // the last entry: so many or more
    pixels[kMostDepth] += pixels.back();
    pixels.pop_back();
  }
  return {{"views", views.size()},
          {"mean", all.mean()},
          {"p95", all.percentile(0.95)},
          {"most", all.most()},
          {"pixels_by_surfaces", pixels}};
}

json line(const std::string& what, const std::string& why) {
  return {{"what", what}, {"why", why}};
}

json usedJson(const SceneSnapshot& scene, const Plan& plan, const Culler& culler) {
  const bool flat = scene.objectCount() <= WideBvh::kFewObjects;
  json used = json::array({line(std::string(plan.frustum->info().name),
                                flat ? "a flat list of boxes" : "a hierarchy")});
  for (const PlannedStage& stage : plan.stages) {
    if (stage.built) used.push_back(line(std::string(stage.method->info().name), stage.why));
  }
  return {{"stages", used}, {"prepared_bytes", culler.preparedBytes()}};
}

json leftOutJson(const SceneSnapshot& scene, const Plan& plan) {
  json out = json::array();
  if (scene.objectCount() <= WideBvh::kFewObjects) {
    out.push_back(line("hierarchy of boxes", "few objects: a flat list answers sooner"));
  }
  if (plan.stages.empty()) out.push_back(line("occlusion", plan.why));
  for (const PlannedStage& stage : plan.stages) {
    if (stage.built) continue;
    out.push_back(line("occlusion (" + std::string(stage.method->info().name) + ")",
                       stage.why + "; not built, built if a view's retry asks for it"));
  }
  for (const StageLeftOut& other : plan.others) {
    out.push_back(line(std::string(other.name), other.why));
  }
  out.push_back(line("normals, colours, texture coordinates, materials",
                     "no stage needs them: only positions are kept of what a file holds"));
  return out;
}

struct Contender {
  std::string name;
  const Culler* culler;
  std::vector<double> path_us;
  double objects = 0.0, triangles = 0.0;
  std::size_t by_occlusion = 0;
};

void walk(const SceneSnapshot& scene, std::span<const Camera> cameras, const Plan& plan,
          std::vector<Contender>& contenders) {
  const double share = 1.0 / static_cast<double>(cameras.size());
  for (std::size_t round = 0; round < kRounds; ++round) {
    std::vector<ViewState> views(contenders.size());
    for (Contender& c : contenders) c.path_us.push_back(0.0);
    for (std::size_t i = 0; i < cameras.size() * contenders.size(); ++i) {
      const std::size_t who = (i + round) % contenders.size();
      Contender& c = contenders[who];
      const Answer answer = c.culler->cull(cameras[i / contenders.size()], {}, views[who]);
      c.path_us.back() += share * us(answer.stats.time);
      if (round != 0) continue;
      c.objects += share * static_cast<double>(answer.visible.size());
      for (const ObjectId id : answer.visible) {
        c.triangles +=
            share * static_cast<double>(scene.mesh(scene.instance(id).mesh).triangles.size());
      }
      const std::string_view maker = answer.made_by.empty() ? c.name : answer.made_by;
      if (maker != plan.frustum->info().name) ++c.by_occlusion;
    }
  }
}

Result<json> camerasJson(const SnapshotPtr& scene, const Plan& plan, const Culler& automatic,
                         std::span<const Camera> cameras) {
  std::vector<std::unique_ptr<Culler>> owned;
  std::vector<Contender> contenders;
  std::vector<const Method*> methods{plan.frustum};
  for (const PlannedStage& stage : plan.stages) methods.push_back(stage.method);
  for (const Method* method : methods) {
    auto culler = method->prepare(scene);
    if (!culler) return std::move(culler).error();
    owned.push_back(std::move(culler).value());
    contenders.push_back({std::string(method->info().name), owned.back().get(), {}});
  }
  contenders.push_back({"auto", &automatic, {}});
  walk(*scene, cameras, plan, contenders);
  json rows = json::array();
  for (Contender& c : contenders) {
    std::sort(c.path_us.begin(), c.path_us.end());
    const double sent_us = c.objects * us(kObjectPrice) + c.triangles * us(kTrianglePrice);
    rows.push_back({{"method", c.name},
                    {"min_us", c.path_us.front()},
                    {"median_us", c.path_us[c.path_us.size() / 2]},
                    {"objects", c.objects},
                    {"triangles", c.triangles},
                    {"price_us", c.path_us.front() + sent_us},
                    {"with_occlusion", c.by_occlusion}});
  }
  return json{{"count", cameras.size()}, {"rounds", kRounds}, {"methods", rows}};
}

}  // namespace

std::vector<Camera> depthViews(const SceneSnapshot& scene, std::span<const Camera> cameras) {
  std::vector<Camera> views;
  if (cameras.empty()) {
    for (const SampledView& view : sampleViews(scene, kDepthViews)) views.push_back(view.camera);
    return views;
  }
  const std::size_t step = (cameras.size() + kDepthViews - 1) / kDepthViews;
  for (std::size_t i = 0; i < cameras.size(); i += step) views.push_back(cameras[i]);
  return views;
}

Result<std::string> planReport(const std::string& file, const SnapshotPtr& scene,
                               const Method& automatic, std::span<const Camera> cameras) {
  auto prepared = automatic.prepare(scene);
  if (!prepared) return std::move(prepared).error();
  const Culler& culler = *prepared.value();
  const Plan& plan = *planOf(culler);
  json report{{"scene", sceneJson(*scene, plan.profile)},
              {"prices", {{"object_us", us(kObjectPrice)}, {"triangle_us", us(kTrianglePrice)}}},
              {"views", viewsJson(plan)},
              {"used", usedJson(*scene, plan, culler)},
              {"left_out", leftOutJson(*scene, plan)}};
  report["depth"] = depthJson(*scene, cameras);
  report["scene"]["file"] = file;
  if (!cameras.empty()) {
    auto measured = camerasJson(scene, plan, culler, cameras);
    if (!measured) return std::move(measured).error();
    report["cameras"] = std::move(measured).value();
  }
  // A file's name may hold bytes that are not UTF-8.
  return report.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace culld
