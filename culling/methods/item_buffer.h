// Method `item-buffer`: the triangles of all objects in the frustum drawn on the GPU with the
// number of their object; what the image holds at its samples is the answer (Weghorst, Hooper,
// Greenberg 1984). Sampled: what shows between samples may be missed. Departs from the source:
// surfaces that do not block, and those at the depth of what hides them, are asked without taking a
// sample.
#pragma once
#include "culling/culler.h"

namespace culld {

const Method& itemBufferMethod() noexcept;

}  // namespace culld
