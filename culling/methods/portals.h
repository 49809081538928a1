// Method `portals`: a scene's polygons become voxels, and voxels a few large solids that hide what
// is behind them (after Umbra 3, Silvennoinen et al. 2011: occlusion data made automatically from
// any polygons). Departs from it: voxels block only where they are proven to lie inside closed
// surfaces, so no hole is lost, however small (docs/error-model/solids.md); and what is drawn is
// these solids, not the portals between them.
#pragma once
#include "culling/culler.h"

namespace culld {

const Method& portalsMethod() noexcept;

}  // namespace culld
