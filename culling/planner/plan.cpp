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

std::string verdict(const PlannedStage& stage) {
  return std::string(stage.method->info().name) + " pays in " + std::to_string(stage.paysIn()) +
         " of " + std::to_string(stage.views.size()) + " sampled views, " + inMs(stage.meanGain()) +
         " a view on average";
}

/// Where `cheaper` pays, that is what answers without the stage.
void setBeside(const StageTrial& cheaper, std::vector<PlannedView>& views) {
  views.resize(std::min(views.size(), cheaper.views.size()));
  for (std::size_t i = 0; i < views.size(); ++i) {
    const PlannedView& view = cheaper.views[i];
    if (worth(view).count() == 0) continue;
    views[i].base_visible = view.visible;
    views[i].base_work = view.work;
    views[i].gain -= view.gain;
  }
}

/// Sampled views are guesses at what clients will ask, so a stage is built if it pays in nearly
/// half of them and on the whole.
PlannedStage planned(const Method* method, std::vector<PlannedView> views) {
  PlannedStage stage{method, std::move(views), {}, false};
  stage.why = verdict(stage);
  stage.built = 20 * stage.paysIn() >= 9 * stage.views.size() && stage.meanGain().count() > 0;
  return stage;
}

void explain(std::span<const StageTrial> tried, const StageChoice& choice, Plan& plan) {
  for (const PlannedStage& stage : plan.stages)
    plan.why += (plan.why.empty() ? "" : "; ") + stage.why;
  const StageTrial& best = tried[choice.best];
  for (std::size_t k = 0; k < tried.size(); ++k) {
    if (k == choice.best || choice.cheaper == k) continue;
    plan.others.push_back({tried[k].method->info().name,
                           "brings " + inMs(advantage(best, tried[k])) + " a view less than " +
                               std::string(best.method->info().name)});
  }
}

void decide(std::vector<StageTrial> tried, Plan& plan, PreparedPlan& prepared) {
  const StageChoice choice = bestStages(tried, plan.object_price);
  std::vector<PlannedView> views = tried[choice.best].views;
  if (choice.cheaper) {
    const StageTrial& cheaper = tried[*choice.cheaper];
    plan.stages.push_back(planned(cheaper.method, cheaper.views));
    setBeside(cheaper, views);
  }
  plan.stages.push_back(planned(tried[choice.best].method, std::move(views)));
  for (StageTrial& trial : tried) plan.planning_work += trial.work;
  explain(tried, choice, plan);
  for (const PlannedStage& stage : plan.stages) {
    const std::size_t k = stage.method == tried[choice.best].method ? choice.best : *choice.cheaper;
    prepared.stages.push_back(stage.built ? std::move(tried[k].culler) : nullptr);
  }
}

}  // namespace

std::size_t PlannedStage::paysIn() const noexcept {
  return static_cast<std::size_t>(std::count_if(
      views.begin(), views.end(), [](const PlannedView& view) { return view.gain.count() > 0; }));
}

nanoseconds PlannedStage::meanGain() const noexcept { return mean(views, &PlannedView::gain); }

nanoseconds PlannedStage::meanWork() const noexcept { return mean(views, &PlannedView::work); }

double PlannedStage::meanBaseShare() const noexcept {
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
  plan.frustum = stages.value().frustum;
  PreparedPlan prepared;
  auto frustum = plan.frustum->prepare(scene, clock);
  if (!frustum) return std::move(frustum).error();
  prepared.frustum = std::move(frustum).value();
  if (plan.profile.blocking_triangles == 0) {
    plan.why = "nothing in the scene blocks a view";
  } else {
    plan.others = std::move(stages.value().refused);
    StageTrials trials =
        tryStages(stages.value().occlusion, scene, *prepared.frustum, plan.object_price, clock);
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
