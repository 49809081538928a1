// Tries methods for the stages of a plan: each is prepared and looked through the same sampled
// views, beside the cheapest method, and the best pair of them is found. docs/planner.md.
#pragma once
#include <chrono>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "culling/planner/plan.h"

namespace culld {

/// A method as a stage of a scene's plan. Its views have the cheapest method as their base.
struct StageTrial {
  const Method* method = nullptr;
  std::unique_ptr<Culler> culler;
  std::vector<PlannedView> views;    ///< the first of the sampled ones, in their order
  std::chrono::nanoseconds work{0};  ///< counted, of looking through them
};

struct StageTrials {
  std::vector<StageTrial> tried;
  std::vector<StageLeftOut> untried;  ///< and why
};

/// One method after another; only the first if it costs so little that no other could save much.
/// REQUIRES: the first is the one that hides most. COST: at most 32 views each, stopped after 100
/// ms of counted work. GUARANTEES: the same on every machine.
StageTrials tryStages(std::span<const Method* const> methods, const SnapshotPtr& scene,
                      const Culler& frustum, std::chrono::nanoseconds object_price,
                      const Clock& clock);

/// By index among those tried.
struct StageChoice {
  std::optional<std::size_t> base;  ///< none: the cheapest method
  std::size_t occlusion = 0;
};

/// The occlusion stage that brings most where it pays; and the base, which works less than that, if
/// another than the cheapest method makes the answers cheaper by a fortieth. REQUIRES: one was
/// tried.
StageChoice bestStages(std::span<const StageTrial> tried, std::chrono::nanoseconds object_price);

/// What `one` brings a view more than `other`, in the views that both looked through.
std::chrono::nanoseconds advantage(const StageTrial& one, const StageTrial& other);

}  // namespace culld
