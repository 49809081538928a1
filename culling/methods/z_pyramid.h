// Method `z-pyramid`: hierarchical visibility (Greene, Kass, Miller 1993, "Hierarchical Z-buffer
// visibility"). An octree is walked front to back, the objects of its visible nodes are drawn into
// a Z-pyramid, and nodes whose boxes the pyramid hides end the walk. Departs from it: depths are
// those that hold for a whole cell instead of its centre, so that nothing visible is lost
// (docs/methods/z-pyramid.md).
#pragma once
#include "culling/culler.h"

namespace culld {

const Method& zPyramidMethod() noexcept;

}  // namespace culld
