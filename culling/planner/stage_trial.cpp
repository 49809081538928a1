#include "culling/planner/stage_trial.h"

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "culling/planner/sample_views.h"

namespace culld {
namespace {

using std::chrono::nanoseconds;

constexpr std::size_t kMostViews = 32, kLeastViews = 4;
constexpr nanoseconds kMostWork = std::chrono::milliseconds(100);
constexpr int kLeastSaving = 40;  ///< one part in so many, for a second stage

PlannedView lookThrough(const Camera& camera, const Culler& frustum, const Culler& stage,
                        nanoseconds object_price) {
  ViewState fresh_frustum, fresh_stage;
  const Answer without = frustum.cull(camera, {}, fresh_frustum);
  Demand bounded;
  bounded.work = kMostWork;  // cut short, it counts what it brought until then
  const Answer with = stage.cull(camera, bounded, fresh_stage);
  PlannedView view;
  view.camera = camera;
  view.in_frustum = view.base_visible = static_cast<std::uint32_t>(without.visible.size());
  view.visible = static_cast<std::uint32_t>(with.visible.size());
  view.base_work = without.stats.work;
  view.work = with.stats.work;
  const auto left_out =
      static_cast<std::int64_t>(view.base_visible) - static_cast<std::int64_t>(view.visible);
  view.gain = object_price * left_out - (view.work - view.base_work);
  return view;
}

void lookAround(std::span<const SampledView> sampled, const Culler& frustum,
                nanoseconds object_price, StageTrial& trial) {
  for (const SampledView& view : sampled) {
    if (trial.views.size() >= kLeastViews && trial.work > kMostWork) break;
    trial.views.push_back(lookThrough(view.camera, frustum, *trial.culler, object_price));
    trial.work += trial.views.back().base_work + trial.views.back().work;
  }
}

/// A tenth of what the answers cost, with their objects, is its work at most: whatever hides as
/// much for no work at all would hardly be worth more.
bool costsLittle(const StageTrial& trial, nanoseconds object_price) {
  nanoseconds work{0}, sent{0};
  for (const PlannedView& view : trial.views) {
    work += view.work;
    sent += object_price * view.visible;
  }
  return 10 * work <= work + sent;
}

std::size_t viewsOfAll(std::span<const StageTrial> tried) {
  std::size_t views = kMostViews;
  for (const StageTrial& trial : tried) views = std::min(views, trial.views.size());
  return views;
}

/// What all views bring, each answered by one or the other, whichever is better there, or by
/// neither.
nanoseconds brings(const StageTrial& one, const StageTrial& other, std::size_t views) {
  nanoseconds sum{0};
  for (std::size_t i = 0; i < views; ++i)
    sum += std::max(worth(one.views[i]), worth(other.views[i]));
  return sum;
}

nanoseconds workOf(const StageTrial& trial, std::size_t views) {
  nanoseconds sum{0};
  for (std::size_t i = 0; i < views; ++i) sum += trial.views[i].work;
  return sum;
}

}  // namespace

StageTrials tryStages(std::span<const Method* const> methods, const SnapshotPtr& scene,
                      const Culler& frustum, nanoseconds object_price, const Clock& clock) {
  const std::vector<SampledView> sampled = sampleViews(*scene, kMostViews);
  StageTrials trials;
  std::string cheap;
  for (const Method* method : methods) {
    const std::string_view name = method->info().name;
    if (!cheap.empty()) {
      trials.untried.push_back({name, "not tried: " + cheap + " costs too little to save"});
      continue;
    }
    auto culler = method->prepareBeside(frustum, scene, clock);
    if (!culler) {
      trials.untried.push_back({name, culler.error().message});
      continue;
    }
    StageTrial trial{method, std::move(culler).value(), {}, {}};
    lookAround(sampled, frustum, object_price, trial);
    if (trials.tried.empty() && costsLittle(trial, object_price)) cheap = name;
    trials.tried.push_back(std::move(trial));
  }
  return trials;
}

nanoseconds worth(const PlannedView& view) noexcept { return std::max(view.gain, nanoseconds{0}); }

StageChoice bestStages(std::span<const StageTrial> tried, nanoseconds object_price) {
  const std::size_t views = viewsOfAll(tried);
  StageChoice best;
  for (std::size_t s = 1; s < tried.size(); ++s) {
    if (advantage(tried[s], tried[best.best]).count() > 0) best.best = s;
  }
  const nanoseconds alone = brings(tried[best.best], tried[best.best], views);
  nanoseconds cost = -alone;  // of all answers
  for (std::size_t i = 0; i < views; ++i) {
    const PlannedView& view = tried.front().views[i];
    cost += view.base_work + object_price * view.in_frustum;
  }
  nanoseconds least = alone + cost / kLeastSaving;
  for (std::size_t c = 0; c < tried.size(); ++c) {
    for (std::size_t s = 0; s < tried.size(); ++s) {
      const nanoseconds pair = brings(tried[c], tried[s], views);
      if (pair <= least || workOf(tried[c], views) >= workOf(tried[s], views)) continue;
      least = pair;
      best = {s, c};
    }
  }
  return best;
}

nanoseconds advantage(const StageTrial& one, const StageTrial& other) {
  const std::size_t both = std::min(one.views.size(), other.views.size());
  nanoseconds sum{0};
  for (std::size_t i = 0; i < both; ++i) sum += worth(one.views[i]) - worth(other.views[i]);
  return both == 0 ? sum : sum / static_cast<std::int64_t>(both);
}

}  // namespace culld
