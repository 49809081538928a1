// Method `backface-clusters`: leaves out objects of which all triangles turn away, and draws
// occluders without the clusters of triangles that do (hierarchical back-face computation; Kumar,
// Manocha, Garrett, Lin 1999). Departs from it: regions have margins, and what is answered is
// objects, not triangles (docs/error-model/backface-clusters.md).
#pragma once
#include "culling/culler.h"

namespace culld {

const Method& backfaceClustersMethod() noexcept;

}  // namespace culld
