// Watches, for one view, whether an occlusion stage earns its cost where the camera is, and
// switches it off and on with hysteresis. Counts work and never asks a clock, so equal sequences of
// cameras decide equally. docs/planner.md; docs/adr/0008.
#pragma once
#include <chrono>
#include <cstdint>
#include <memory>
#include <vector>

#include "culling/planner/plan.h"

namespace culld {

/// What one frame showed, with the stage or without it.
struct WatchedFrame {
  std::chrono::nanoseconds work{0};
  std::uint32_t in_frustum = 0;  ///< 0: not counted, time ran out
  std::uint32_t visible = 0;
};

class Watch {
 public:
  /// REQUIRES: `stage` is one of plan->stages.
  Watch(std::shared_ptr<const Plan> plan, std::size_t stage);

  /// Shall this camera be answered with the stage? To be followed by one of the saw functions.
  bool wantsStage(const Camera& camera);
  void sawStage(const WatchedFrame& frame);
  void sawBase(const WatchedFrame& frame);  ///< of what answers without it

  /// Frames with the stage while it was switched off, and their work.
  std::uint32_t retries() const noexcept { return retries_; }
  std::uint32_t switches() const noexcept { return switches_; }

 private:
  using Work = std::chrono::nanoseconds;
  /// The surroundings of one sampled view: cameras next to it share what was learned there.
  struct Place {
    bool on = false;
    bool visited = false;
    Work balance{0};          ///< of what the stage brought lately
    Work expected{0};         ///< work of the stage the last time here
    double base_share = 1.0;  ///< what was answered here without it of what was in the frustum
  };
  std::size_t placeOf(const Camera& camera) const;
  bool mayRetry() const;
  /// Objects, were this camera answered without the stage.
  std::int64_t baseAnswers(const Place& place) const;
  bool planned(const Place& place) const { return place.on && (place.visited || trust_ > 0); }
  void learn(Place& place, bool pays);
  void switchTo(Place& place, bool on);

  std::shared_ptr<const Plan> plan_;
  const PlannedStage* stage_;  ///< of plan_
  std::vector<Place> places_;
  std::size_t here_ = 0;
  double reach_ = 1.0;  ///< distance that counts as much as half a turn
  int trust_;           ///< in what the plan says of places not visited yet
  Work saved_up_{0};    ///< for retries: a share of what answers without it have cost since
  std::uint32_t in_frustum_ = 0;
  std::size_t tried_place_ = 0;
  std::uint32_t tried_in_frustum_ = 0;
  std::uint32_t retries_ = 0, switches_ = 0;
};

}  // namespace culld
