#include "culling/planner/plan.h"

#include <algorithm>
#include <utility>

#include "culling/planner/price.h"
#include "culling/planner/scene_profile.h"
#include "culling/planner/stage_trial.h"

namespace culld {
namespace {

using std::chrono::nanoseconds;

/// What a method needs, as MethodInfo says it: boxes make the cheapest methods.
constexpr std::string_view kBoxes = "boxes";

nanoseconds mean(std::span<const PlannedView> views, nanoseconds PlannedView::*part) {
  nanoseconds sum{0};
  for (const PlannedView& view : views) sum += view.*part;
  return views.empty() ? sum : sum / std::ssize(views);
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
  return std::string(plan.occlusion->info().name) + " pays in " +
         std::to_string(viewsThatPay(plan)) + " of " + std::to_string(plan.views.size()) +
         " sampled views, " + inMs(plan.meanGain()) + " a view on average" +
         (plan.why_base.empty() ? "" : ", beside " + std::string(plan.base->info().name));
}

/// The views of `occlusion`, with `base` in the place of the cheapest method.
std::vector<PlannedView> viewsBeside(const StageTrial& base, std::vector<PlannedView> views) {
  views.resize(std::min(views.size(), base.views.size()));
  for (std::size_t i = 0; i < views.size(); ++i) {
    views[i].base_visible = base.views[i].visible;
    views[i].base_work = base.views[i].occlusion_work;
    views[i].gain -= base.views[i].gain;
  }
  return views;
}

void explainOthers(std::span<const StageTrial> tried, const StageChoice& choice, Plan& plan) {
  const StageTrial& best = tried[choice.occlusion];
  for (std::size_t k = 0; k < tried.size(); ++k) {
    if (k == choice.occlusion || choice.base == k) continue;
    plan.others.push_back({tried[k].method->info().name,
                           "brings " + inMs(advantage(best, tried[k])) + " a view less than " +
                               std::string(best.method->info().name)});
  }
}

/// Sampled views are guesses at what clients will ask, so the occlusion stage is built if it pays
/// in nearly half of them and on the whole.
void decide(std::vector<StageTrial> tried, Plan& plan, PreparedPlan& prepared) {
  const StageChoice choice = bestStages(tried, plan.object_price);
  StageTrial& best = tried[choice.occlusion];
  plan.occlusion = best.method;
  plan.views = best.views;
  if (choice.base) {
    StageTrial& base = tried[*choice.base];
    plan.base = base.method;
    plan.why_base =
        "brings " + inMs(mean(base.views, &PlannedView::gain)) + " a view on average, always used";
    plan.views = viewsBeside(base, best.views);
    prepared.base = std::move(base.culler);
  }
  for (const StageTrial& trial : tried) plan.planning_work += trial.work;
  plan.occlusion_built =
      20 * viewsThatPay(plan) >= 9 * std::ssize(plan.views) && plan.meanGain().count() > 0;
  plan.why = verdict(plan);
  explainOthers(tried, choice, plan);
  if (plan.occlusion_built) prepared.occlusion = std::move(best.culler);
}

}  // namespace

nanoseconds Plan::meanGain() const noexcept { return mean(views, &PlannedView::gain); }

nanoseconds Plan::meanOcclusionWork() const noexcept {
  return mean(views, &PlannedView::occlusion_work);
}

double Plan::meanBaseShare() const noexcept {
  double in_frustum = 0.0, answered = 0.0;
  for (const PlannedView& view : views) {
    in_frustum += view.in_frustum;
    answered += view.base_visible;
  }
  return in_frustum > 0.0 ? answered / in_frustum : 1.0;
}

Result<Stages> chooseStages(const SceneProfile& profile, std::span<const Method* const> methods) {
  Stages found;
  for (const Method* method : methods) {
    const MethodInfo info = method->info();
    if (info.guarantee != Guarantee::kConservative) continue;
    if (auto accepted = method->accepts(profile); !accepted) {
      found.refused.push_back({info.name, accepted.error().message});
    } else if (found.frustum == nullptr && info.needs == kBoxes) {
      found.frustum = method;
    } else {
      found.occlusion.push_back(method);
    }
  }
  if (found.frustum == nullptr && !found.occlusion.empty()) {
    found.frustum = found.occlusion.front();
    found.occlusion.erase(found.occlusion.begin());
  }
  if (found.frustum != nullptr) return found;
  std::string refusals;
  for (const StageLeftOut& one : found.refused)
    refusals += "; " + std::string(one.name) + ": " + one.why;
  return Error{ErrorCode::kUnsupported, "no conservative method is for this scene" + refusals};
}

Result<PreparedPlan> makePlan(const SnapshotPtr& scene, std::span<const Method* const> methods,
                              const Clock& clock) {
  Plan plan;
  plan.profile = profileScene(*scene);
  plan.object_price = meanObjectPrice(plan.profile);
  auto stages = chooseStages(plan.profile, methods);
  if (!stages) return std::move(stages).error();
  plan.base = stages.value().frustum;
  PreparedPlan prepared;
  auto frustum = plan.base->prepare(scene, clock);
  if (!frustum) return std::move(frustum).error();
  prepared.base = std::move(frustum).value();
  if (plan.profile.blocking_triangles == 0) {
    plan.why = "nothing in the scene blocks a view";
  } else {
    plan.others = std::move(stages.value().refused);
    StageTrials trials =
        tryStages(stages.value().occlusion, scene, *prepared.base, plan.object_price, clock);
    plan.others.insert(plan.others.end(), trials.untried.begin(), trials.untried.end());
    if (trials.tried.empty()) {
      plan.why = "no other conservative method is for this scene";
    } else {
      decide(std::move(trials.tried), plan, prepared);
    }
  }
  prepared.plan = std::make_shared<const Plan>(std::move(plan));
  return prepared;
}

}  // namespace culld
