// Method `occlusion-map`: a few good occluders drawn into a map of opacities, everything else
// compared with it in two steps, overlap and depth (Zhang, Manocha, Hudson, Hoff 1997; Zhang 1998).
// Departs from them: what the map calls covered is proven covered, and where holes are accepted the
// pixels that may be lost are counted (docs/methods/occlusion-map.md).
#pragma once
#include "culling/culler.h"

namespace culld {

const Method& occlusionMapMethod() noexcept;

}  // namespace culld
