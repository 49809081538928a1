// Method `layers`: space in cells, each with a solidity, projected where sight is clearest first
// (prioritized-layered projection, Klosowski, Silva 2000). Conservative, what was projected hides
// what was not (as in their cPLP, 2001); approximate, the rest is left out and the pixels lost are
// estimated (docs/methods/layers.md).
#pragma once
#include "culling/culler.h"

namespace culld {

const Method& layersMethod() noexcept;

}  // namespace culld
