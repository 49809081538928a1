// What is used for a scene and what is left out, decided before the first camera from counted work
// on sampled views. docs/planner.md.
#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "culling/culler.h"

namespace culld {

/// One sampled view, answered with and without the occlusion stage.
struct PlannedView {
  Camera camera;
  std::uint32_t in_frustum = 0, visible = 0;  ///< objects
  std::chrono::nanoseconds frustum_work{0}, occlusion_work{0};
  /// Price of the objects that occlusion leaves out, less its work.
  std::chrono::nanoseconds gain{0};
};

struct Plan {
  SceneProfile profile;
  std::chrono::nanoseconds object_price{0};  ///< of sending one object more
  const Method* frustum = nullptr;           ///< always there: the cheapest conservative method
  const Method* occlusion = nullptr;  ///< what may be switched on; none: nothing could ever pay
  bool occlusion_built = false;  ///< it pays in nearly half of the sampled views: built at once
  std::string why;               ///< one line, on the occlusion stage
  std::vector<PlannedView> views;
  std::chrono::nanoseconds planning_work{0};  ///< counted, of looking through all views

  std::chrono::nanoseconds meanGain() const noexcept;
  std::chrono::nanoseconds meanOcclusionWork() const noexcept;
};

/// A plan and the cullers that making it has prepared and that it uses.
struct PreparedPlan {
  std::shared_ptr<const Plan> plan;
  std::unique_ptr<Culler> frustum;
  std::unique_ptr<Culler> occlusion;  ///< none unless plan->occlusion_built
};

struct Stages {
  const Method* frustum = nullptr;    ///< the first that needs boxes only, if there is one
  const Method* occlusion = nullptr;  ///< the first other one; none: there is no choice
  std::string refusals;               ///< "; NAME: why not" of each that declined the scene
};

/// Of the conservative methods among `methods` that accept the scene.
/// ERROR: kUnsupported: there is none.
Result<Stages> chooseStages(const SceneProfile& profile, std::span<const Method* const> methods);

/// GUARANTEES: the same plan on every machine. COST: preparing both and
/// looking through at most 32 views, stopped after 100 ms of counted work.
/// ERROR: as chooseStages().
Result<PreparedPlan> makePlan(const SnapshotPtr& scene, std::span<const Method* const> methods,
                              const Clock& clock);

}  // namespace culld
