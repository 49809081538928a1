// Method `gpu-depth-pyramid`: occluders drawn on the GPU in two passes, what the last frame saw and
// then what this one finds, and all boxes asked against a pyramid of this frame's farthest depths
// (today's practice; the pyramid after Greene, Kass, Miller 1993). Departs from practice: a cell is
// covered only if all of it is proven covered, and the pyramid is aligned to powers of two
// (docs/error-model/gpu.md).
#pragma once
#include "culling/culler.h"

namespace culld {

const Method& gpuDepthPyramidMethod() noexcept;

}  // namespace culld
