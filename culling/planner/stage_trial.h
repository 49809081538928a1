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

/// A method as a stage of a scene's plan. In its views the cheapest method answers without it.
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
  std::size_t best = 0;
  std::optional<std::size_t> cheaper;  ///< used where `best` does not pay, and works less
};

/// The stage that brings most where it pays; and another beside it, if the two make the answers
/// cheaper by a fortieth than the best alone. REQUIRES: one was tried.
StageChoice bestStages(std::span<const StageTrial> tried, std::chrono::nanoseconds object_price);

/// What a stage brings in a view: nothing where it does not pay, as it is switched off there.
std::chrono::nanoseconds worth(const PlannedView& view) noexcept;

/// What `one` brings a view more than `other`, in the views that both looked through.
std::chrono::nanoseconds advantage(const StageTrial& one, const StageTrial& other);

}  // namespace culld
