#include "culling/planner/plan.h"

#include <algorithm>
#include <utility>

#include "culling/planner/price.h"
#include "culling/planner/sample_views.h"
#include "culling/planner/scene_profile.h"

namespace culld {
namespace {

using std::chrono::nanoseconds;

constexpr std::size_t kMostViews = 32, kLeastViews = 4;
constexpr nanoseconds kMostWork = std::chrono::milliseconds(100);

/// What a method needs, as MethodInfo says it: boxes make the cheapest methods.
constexpr std::string_view kBoxes = "boxes";

PlannedView lookThrough(const Camera& camera, const Culler& frustum, const Culler& occlusion,
                        nanoseconds object_price) {
  ViewState fresh_frustum, fresh_occlusion;
  const Answer without = frustum.cull(camera, {}, fresh_frustum);
  Demand bounded;
  bounded.work = kMostWork;  // cut short, it counts what occlusion brought until then
  const Answer with = occlusion.cull(camera, bounded, fresh_occlusion);
  PlannedView view;
  view.camera = camera;
  view.in_frustum = static_cast<std::uint32_t>(without.visible.size());
  view.visible = static_cast<std::uint32_t>(with.visible.size());
  view.frustum_work = without.stats.work;
  view.occlusion_work = with.stats.work;
  const auto left_out =
      static_cast<std::int64_t>(view.in_frustum) - static_cast<std::int64_t>(view.visible);
  view.gain = object_price * left_out - (view.occlusion_work - view.frustum_work);
  return view;
}

void lookAround(const SceneSnapshot& scene, const Culler& frustum, const Culler& occlusion,
                Plan& plan) {
  for (const SampledView& view : sampleViews(scene, kMostViews)) {
    if (plan.views.size() >= kLeastViews && plan.planning_work > kMostWork) break;
    plan.views.push_back(lookThrough(view.camera, frustum, occlusion, plan.object_price));
    plan.planning_work += plan.views.back().frustum_work + plan.views.back().occlusion_work;
  }
}

std::string inMs(nanoseconds time) {
  const double ms = std::chrono::duration<double, std::milli>(time).count();
  char text[32];
  std::snprintf(text, sizeof text, "%.3g ms", ms);
  return text;
}

std::ptrdiff_t viewsThatPay(const Plan& plan) {
  return std::count_if(plan.views.begin(), plan.views.end(),
                       [](const PlannedView& view) { return view.gain.count() > 0; });
}

std::string verdict(const Plan& plan) {
  const auto pays = viewsThatPay(plan);
  return std::string(plan.occlusion->info().name) + " pays in " + std::to_string(pays) + " of " +
         std::to_string(plan.views.size()) + " sampled views, " + inMs(plan.meanGain()) +
         " a view on average";
}

/// Prepares the occlusion stage and looks through it. Sampled views are guesses at what clients
/// will ask, so it is kept if it pays in nearly half of them and on the whole.
Result<Done> tryOcclusion(const SnapshotPtr& scene, const Clock& clock, Plan& plan,
                          PreparedPlan& prepared) {
  auto occlusion = plan.occlusion->prepareBeside(*prepared.frustum, scene, clock);
  if (!occlusion) return std::move(occlusion).error();
  lookAround(*scene, *prepared.frustum, *occlusion.value(), plan);
  plan.occlusion_built =
      20 * viewsThatPay(plan) >= 9 * std::ssize(plan.views) && plan.meanGain().count() > 0;
  plan.why = verdict(plan);
  if (plan.occlusion_built) prepared.occlusion = std::move(occlusion).value();
  return Done{};
}

}  // namespace

nanoseconds Plan::meanGain() const noexcept {
  nanoseconds sum{0};
  for (const PlannedView& view : views) sum += view.gain;
  return views.empty() ? sum : sum / static_cast<std::int64_t>(views.size());
}

nanoseconds Plan::meanOcclusionWork() const noexcept {
  nanoseconds sum{0};
  for (const PlannedView& view : views) sum += view.occlusion_work;
  return views.empty() ? sum : sum / static_cast<std::int64_t>(views.size());
}

Result<Stages> chooseStages(const SceneProfile& profile, std::span<const Method* const> methods) {
  Stages found;
  for (const Method* method : methods) {
    const MethodInfo info = method->info();
    if (info.guarantee != Guarantee::kConservative) continue;
    const Method*& place = info.needs == kBoxes ? found.frustum : found.occlusion;
    if (place != nullptr) continue;
    if (auto accepted = method->accepts(profile); accepted) {
      place = method;
    } else {
      found.refusals += "; " + std::string(info.name) + ": " + accepted.error().message;
    }
  }
  if (found.frustum == nullptr) std::swap(found.frustum, found.occlusion);
  if (found.frustum != nullptr) return found;
  return Error{ErrorCode::kUnsupported,
               "no conservative method is for this scene" + found.refusals};
}

Result<PreparedPlan> makePlan(const SnapshotPtr& scene, std::span<const Method* const> methods,
                              const Clock& clock) {
  Plan plan;
  plan.profile = profileScene(*scene);
  plan.object_price = meanObjectPrice(plan.profile);
  const auto stages = chooseStages(plan.profile, methods);
  if (!stages) return stages.error();
  plan.frustum = stages.value().frustum;
  PreparedPlan prepared;
  auto frustum = plan.frustum->prepare(scene, clock);
  if (!frustum) return std::move(frustum).error();
  prepared.frustum = std::move(frustum).value();
  if (plan.profile.blocking_triangles == 0) {
    plan.why = "nothing in the scene blocks a view";
  } else if (stages.value().occlusion == nullptr) {
    plan.why = "no other conservative method is for this scene" + stages.value().refusals;
  } else {
    plan.occlusion = stages.value().occlusion;
    if (auto tried = tryOcclusion(scene, clock, plan, prepared); !tried) {
      plan.occlusion = nullptr;
      plan.why = tried.error().message;
    }
  }
  prepared.plan = std::make_shared<const Plan>(std::move(plan));
  return prepared;
}

}  // namespace culld
