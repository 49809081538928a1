// The plan that a scene's answers follow, in the words of the status page.
#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/scene.h"

namespace culld::server {

struct PlanSummary {
  std::vector<std::string_view> stages;  ///< names of methods
  std::string_view occlusion;            ///< whether one of them is on beside the frustum
  std::string why;                       ///< one line about them
  double gain_us = 0;                    ///< of all of them, per sampled view
};

/// None while no view has asked `auto` about this version. Does not wait. THREADS: any.
std::optional<PlanSummary> summarizePlan(const SceneVersion& version);

}  // namespace culld::server
