// A still camera's view becomes one that shows what every pose within a motion bound sees.
// docs/error-model/motion.md proves it.
#pragma once
#include "culling/raster/cell_view.h"

namespace culld {

/// REQUIRES: `view` made for the camera as if it were still. False if there is no such view: then
/// nothing may be drawn or looked up in it.
bool setInMotion(CellView& view, const MotionBound& bound) noexcept;

/// `view` for asking what of a surface can be seen through it. From elsewhere its other side may be
/// seen, and a cut that is safe for blockers is not for them: in motion all of it counts.
CellView askedView(const CellView& view) noexcept;

}  // namespace culld
