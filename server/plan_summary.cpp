#include "server/plan_summary.h"

#include "culling/planner/auto_method.h"

namespace culld::server {

std::optional<PlanSummary> summarizePlan(const SceneVersion& version) {
  const auto method = version.method("auto");
  const auto culler = method ? version.readyCuller(*method.value()) : nullptr;
  const Plan* plan = culler == nullptr ? nullptr : planOf(*culler);
  if (plan == nullptr) return std::nullopt;
  PlanSummary summary;
  summary.stages.push_back(plan->frustum->info().name);
  bool on = false;
  for (const PlannedStage& stage : plan->stages) {
    summary.stages.push_back(stage.method->info().name);
    on = on || stage.built;
    summary.gain_us += std::chrono::duration<double, std::micro>(stage.meanGain()).count();
  }
  summary.occlusion = plan->stages.empty() ? "left out"
                      : on                 ? "on"
                                           : "when a view shows that it pays";
  summary.why = plan->why;
  return summary;
}

}  // namespace culld::server
