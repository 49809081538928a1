// Method `polygon-tiling`: hierarchical polygon tiling (Greene 1996, "Hierarchical polygon tiling
// with coverage masks"). An octree of BSP trees is met strictly front to back, so a pyramid of
// coverage masks says what is hidden, without depths. Departs from it: cells count as covered only
// if all of them is, and objects are what is met (docs/methods/polygon-tiling.md).
#pragma once
#include "culling/culler.h"

namespace culld {

const Method& polygonTilingMethod() noexcept;

}  // namespace culld
