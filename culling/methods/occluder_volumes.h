// Method `occluder-volumes`: leaves out what lies wholly within the space that one large convex
// occluder hides. Works on boxes and planes alone, without an image (Bacik 2002, "Rendering the
// Great Outdoors"; Hudson et al. 1997, "Accelerated occlusion culling using shadow frusta").
// Departs from them: margins make it sound (docs/error-model/occlusion-volumes.md), and occluders
// are found in the meshes, never larger than what they stand for.
#pragma once
#include "culling/culler.h"

namespace culld {

const Method& occluderVolumesMethod() noexcept;

}  // namespace culld
