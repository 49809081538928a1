#include "server/plan_summary.h"

#include "culling/planner/auto_method.h"

namespace culld::server {

std::optional<PlanSummary> summarizePlan(const SceneVersion& version) {
  const auto method = version.method("auto");
  const auto culler = method ? version.readyCuller(*method.value()) : nullptr;
  const Plan* plan = culler == nullptr ? nullptr : planOf(*culler);
  if (plan == nullptr) return std::nullopt;
  PlanSummary summary;
  summary.stages.push_back(plan->base->info().name);
  if (plan->occlusion != nullptr) summary.stages.push_back(plan->occlusion->info().name);
  summary.occlusion = plan->occlusion == nullptr ? "left out"
                      : plan->occlusion_built    ? "on"
                                                 : "when a view shows that it pays";
  summary.why = plan->why;
  summary.gain_us = std::chrono::duration<double, std::micro>(plan->meanGain()).count();
  return summary;
}

}  // namespace culld::server
