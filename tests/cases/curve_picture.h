// One family's curves as an SVG picture: excess, time and depth slack, each against the steps in
// their order.
#pragma once
#include <string>

#include "tests/cases/curve_files.h"

namespace culld::cases {

/// REQUIRES: at least one step, the same methods in all.
std::string pictureOf(const Curve& curve);

}  // namespace culld::cases
