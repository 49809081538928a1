// Method `horizon`: cities. Sweeps the scene front to back and keeps, per column of the image, the
// rows that buildings passed so far hide; what stays within them is left out (Downs, Moller, Sequin
// 2001, "Occlusion horizons for driving through urban scenery"). Departs from it: rows are proven
// to be covered rather than assumed to be, so nothing is asked of the ground, and any blocking
// object may raise the horizon, not only vertical prisms (docs/methods/horizon.md).
#pragma once
#include "culling/culler.h"

namespace culld {

const Method& horizonMethod() noexcept;

}  // namespace culld
