#include "culling/pairs/places.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <limits>

namespace culld {
namespace {

double above(double x) { return std::nextafter(x, std::numeric_limits<double>::infinity()); }
double below(double x) { return std::nextafter(x, -std::numeric_limits<double>::infinity()); }

}  // namespace

PlaceCorners cornersOf(const Place& place) noexcept {
  Box box = place.box;
  for (int axis = 0; place.radius_m > 0.0 && axis < 3; ++axis) {
    box.min[axis] = below(box.min[axis] - place.radius_m);
    box.max[axis] = above(box.max[axis] + place.radius_m);
  }
  PlaceCorners out;
  out.count = box.min == box.max ? 1 : 8;
  for (std::size_t i = 0; i < out.count; ++i) {
    out.corner[i] = {(i & 1U) != 0 ? box.max.x : box.min.x, (i & 2U) != 0 ? box.max.y : box.min.y,
                     (i & 4U) != 0 ? box.max.z : box.min.z};
    for (int axis = 0; axis < 3; ++axis) {
      out.largest = std::max(out.largest, std::abs(out.corner[i][axis]));
    }
  }
  out.centre = 0.5 * box.min + 0.5 * box.max;
  return out;
}

}  // namespace culld
