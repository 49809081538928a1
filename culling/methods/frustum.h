// Method `frustum`: everything that is not provably outside the frustum is answered. Hierarchical
// view frustum culling with plane masking (Assarsson, Moller 2000, "Optimized view frustum culling
// algorithms for bounding boxes"). Departs from it: eight-wide nodes, and an error margin that
// makes the fp32 tests sound (docs/error-model/frustum.md).
#pragma once
#include "culling/culler.h"

namespace culld {

const Method& frustumMethod() noexcept;

}  // namespace culld
