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

/// One sampled view, answered with a stage and by what answers where the stage is off.
struct PlannedView {
  Camera camera;
  std::uint32_t in_frustum = 0, base_visible = 0, visible = 0;  ///< objects
  std::chrono::nanoseconds base_work{0}, work{0};
  /// Price of the objects that the stage leaves out further, less what it works more.
  std::chrono::nanoseconds gain{0};
};

/// An occlusion method that may be switched on where it pays.
struct PlannedStage {
  const Method* method = nullptr;
  std::vector<PlannedView> views;
  std::string why;     ///< one line
  bool built = false;  ///< it pays in nearly half of the views and on the whole: built at once

  std::size_t paysIn() const noexcept;  ///< views
  std::chrono::nanoseconds meanGain() const noexcept;
  std::chrono::nanoseconds meanWork() const noexcept;
  double meanBaseShare() const noexcept;  ///< what is answered without it of what is in the frustum
};

/// A method that could have been a stage.
struct StageLeftOut {
  std::string_view name;
  std::string why;
};

struct Plan {
  SceneProfile profile;
  std::chrono::nanoseconds object_price{0};  ///< of sending one object more
  const Method* frustum = nullptr;           ///< always there: the cheapest conservative method
  /// The one that works least first; the last that pays where a camera is answers it. None: nothing
  /// could ever pay.
  std::vector<PlannedStage> stages;
  std::string why;                            ///< one line, on the stages
  std::vector<StageLeftOut> others;           ///< which could have been stages
  std::chrono::nanoseconds planning_work{0};  ///< counted, of looking through views
};

/// A plan and the cullers that making it has prepared and that it uses.
struct PreparedPlan {
  std::shared_ptr<const Plan> plan;
  std::unique_ptr<Culler> frustum;
  std::vector<std::unique_ptr<Culler>> stages;  ///< of plan->stages; nullptr unless built
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
