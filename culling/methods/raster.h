// Method `raster`: draws occluders front to back into a grid of cells on the CPU and leaves out
// what lies behind them, walking occluders and occludees in one hierarchy (after the software
// occlusion culling of today's engines; Greene 1993 for the walk). Departs from them: a cell counts
// as covered only if all of it is proven covered, with the farthest depth in it
// (docs/error-model.md §3-§5).
#pragma once
#include "culling/culler.h"

namespace culld {

const Method& rasterMethod() noexcept;

}  // namespace culld
