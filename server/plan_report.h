// What `culld plan` says, as JSON and, made from that, as text for a person.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "culling/core/camera.h"
#include "culling/culler.h"

namespace culld {

/// Prepares `automatic` for the scene and says as JSON what its plan is. With cameras the stages
/// and `auto` are measured on them too, in turn. REQUIRES: `automatic` is an AutoMethod. ERROR: the
/// planner's.
Result<std::string> planReport(const std::string& file, const SnapshotPtr& scene,
                               const Method& automatic, std::span<const Camera> cameras);

/// What depth complexity is measured on: some of the cameras, or of the sampled views if there are
/// none.
std::vector<Camera> depthViews(const SceneSnapshot& scene, std::span<const Camera> cameras);

/// REQUIRES: what planReport() gave.
std::string planText(const std::string& report);

}  // namespace culld
