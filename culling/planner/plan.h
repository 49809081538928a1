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

/// One sampled view, answered by the base alone and with the occlusion stage.
struct PlannedView {
  Camera camera;
  std::uint32_t in_frustum = 0, base_visible = 0, visible = 0;  ///< objects
  std::chrono::nanoseconds base_work{0}, occlusion_work{0};
  /// Price of the objects that occlusion leaves out of what the base answers, less its work.
  std::chrono::nanoseconds gain{0};
};

/// A method that could have been a stage.
struct StageLeftOut {
  std::string_view name;
  std::string why;
};

struct Plan {
  SceneProfile profile;
  std::chrono::nanoseconds object_price{0};  ///< of sending one object more
  /// What answers always: the cheapest conservative method, or one that brings more in nearly every
  /// view.
  const Method* base = nullptr;
  std::string why_base;  ///< one line; empty for the cheapest
  /// What may be switched on: of the others the one that brings most. None: nothing could ever pay.
  const Method* occlusion = nullptr;
  bool occlusion_built = false;      ///< it pays in nearly half of the sampled views: built at once
  std::string why;                   ///< one line, on the occlusion stage
  std::vector<StageLeftOut> others;  ///< which could have been a stage
  std::vector<PlannedView> views;
  std::chrono::nanoseconds planning_work{0};  ///< counted, of looking through views

  std::chrono::nanoseconds meanGain() const noexcept;
  std::chrono::nanoseconds meanOcclusionWork() const noexcept;
  double meanBaseShare() const noexcept;  ///< of the objects in the frustum, what the base answers
};

/// A plan and the cullers that making it has prepared and that it uses.
struct PreparedPlan {
  std::shared_ptr<const Plan> plan;
  std::unique_ptr<Culler> base;
  std::unique_ptr<Culler> occlusion;  ///< none unless plan->occlusion_built
};

struct Stages {
  const Method* frustum = nullptr;       ///< the first that needs boxes only, if there is one
  std::vector<const Method*> occlusion;  ///< the others, in their order
  std::vector<StageLeftOut> refused;     ///< those that declined the scene
};

/// Of the conservative methods among `methods` that accept the scene.
/// ERROR: kUnsupported: there is none.
Result<Stages> chooseStages(const SceneProfile& profile, std::span<const Method* const> methods);

/// GUARANTEES: the same plan on every machine. COST: preparing each stage that is tried and looking
/// through at most 32 views with it, stopped after 100 ms of counted work.
/// ERROR: as chooseStages().
Result<PreparedPlan> makePlan(const SnapshotPtr& scene, std::span<const Method* const> methods,
                              const Clock& clock);

}  // namespace culld
