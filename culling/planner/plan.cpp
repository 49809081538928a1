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

nanoseconds mean(std::span<const PlannedView> views, nanoseconds PlannedView::*part) {
  nanoseconds sum{0};
  for (const PlannedView& view : views) sum += view.*part;
  return views.empty() ? sum : sum / std::ssize(views);
}

/// A method in the place of the occlusion stage.
struct Candidate {
  const Method* method = nullptr;
  std::unique_ptr<Culler> culler;
  std::vector<PlannedView> views;
  nanoseconds work{0};  ///< of looking through them, both stages
};

/// What `one` brings a view more than `other`, in the views that both looked through, each left
/// out where it does not pay: there the watch switches it off.
nanoseconds advantage(const Candidate& one, const Candidate& other) {
  const std::size_t both = std::min(one.views.size(), other.views.size());
  nanoseconds sum{0};
  for (std::size_t i = 0; i < both; ++i) {
    sum += std::max(one.views[i].gain, nanoseconds{0});
    sum -= std::max(other.views[i].gain, nanoseconds{0});
  }
  return both == 0 ? sum : sum / static_cast<std::int64_t>(both);
}

std::string nameOf(const Candidate& candidate) {
  return std::string(candidate.method->info().name);
}

void lookAround(std::span<const SampledView> sampled, const Culler& frustum,
                nanoseconds object_price, Candidate& candidate) {
  for (const SampledView& view : sampled) {
    if (candidate.views.size() >= kLeastViews && candidate.work > kMostWork) break;
    candidate.views.push_back(lookThrough(view.camera, frustum, *candidate.culler, object_price));
    candidate.work += candidate.views.back().frustum_work + candidate.views.back().occlusion_work;
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

/// A tenth of what the answers cost, with their objects, is the candidate's work at most: whatever
/// hides as much for no work at all would hardly be worth more.
bool costsLittle(const Candidate& candidate, nanoseconds object_price) {
  nanoseconds work{0}, sent{0};
  for (const PlannedView& view : candidate.views) {
    work += view.occlusion_work;
    sent += object_price * view.visible;
  }
  return 10 * work <= work + sent;
}

/// The first of `stages`, and one after another those that may bring more, prepared and looked
/// through; the best stays. Its `culler` is none if none can be prepared.
Candidate tryStages(std::span<const Method* const> stages, const SnapshotPtr& scene,
                    const Culler& frustum, const Clock& clock, Plan& plan) {
  const std::vector<SampledView> sampled = sampleViews(*scene, kMostViews);
  Candidate best;
  std::vector<Candidate> worse;
  for (const Method* method : stages) {
    const std::string_view name = method->info().name;
    if (best.culler && costsLittle(best, plan.object_price)) {
      plan.others.push_back({name, "not tried: " + nameOf(best) + " costs too little to save"});
      continue;
    }
    auto culler = method->prepareBeside(frustum, scene, clock);
    if (!culler) {
      plan.others.push_back({name, culler.error().message});
      continue;
    }
    Candidate next{method, std::move(culler).value(), {}, {}};
    lookAround(sampled, frustum, plan.object_price, next);
    if (!best.culler || advantage(next, best).count() > 0) std::swap(best, next);
    if (!next.culler) continue;
    next.culler.reset();
    worse.push_back(std::move(next));
  }
  for (const Candidate& one : worse) {
    plan.others.push_back({one.method->info().name, "brings " + inMs(advantage(best, one)) +
                                                        " a view less than " + nameOf(best)});
  }
  return best;
}

/// Sampled views are guesses at what clients will ask, so the stage is built if it pays in nearly
/// half of them and on the whole.
void decide(Candidate best, Plan& plan, PreparedPlan& prepared) {
  if (!best.culler) {
    plan.why = "no other conservative method is for this scene";
    return;
  }
  plan.occlusion = best.method;
  plan.views = std::move(best.views);
  plan.planning_work = best.work;
  plan.occlusion_built =
      20 * viewsThatPay(plan) >= 9 * std::ssize(plan.views) && plan.meanGain().count() > 0;
  plan.why = verdict(plan);
  if (plan.occlusion_built) prepared.occlusion = std::move(best.culler);
}

}  // namespace

nanoseconds Plan::meanGain() const noexcept { return mean(views, &PlannedView::gain); }

nanoseconds Plan::meanOcclusionWork() const noexcept {
  return mean(views, &PlannedView::occlusion_work);
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
    decide(tryStages(stages.value().occlusion, scene, *prepared.frustum, clock, plan), plan,
           prepared);
  }
  prepared.plan = std::make_shared<const Plan>(std::move(plan));
  return prepared;
}

}  // namespace culld
