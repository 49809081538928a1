// Method `auto`: picks stages for the scene by measuring, and for each view keeps watching whether
// they pay. Knows other methods by their interface only. docs/planner.md; docs/adr/0008.
#pragma once
#include <span>

#include "culling/planner/plan.h"

namespace culld {

class AutoMethod final : public Method {
 public:
  /// Chooses among `stages`, which must outlive it and its cullers.
  explicit AutoMethod(std::span<const Method* const> stages) : stages_(stages) {}

  MethodInfo info() const noexcept override;
  /// ERROR: kUnsupported: no conservative stage accepts the scene.
  Result<void> accepts(const SceneProfile& profile) const override;
  /// The culler's answers are conservative, whatever it leaves out. They may depend on the cameras
  /// that the same ViewState has seen, and on nothing else.
  Result<std::unique_ptr<Culler>> prepare(SnapshotPtr scene, const Clock& clock) const override;

 private:
  std::span<const Method* const> stages_;
};

/// The plan that an `auto` culler follows; nullptr for any other culler.
const Plan* planOf(const Culler& culler) noexcept;

}  // namespace culld
