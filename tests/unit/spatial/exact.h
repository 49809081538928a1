// Exact sums for tests. __float128 has 113 bits: a double (53) plus or minus a float (24) is exact
// in it while their exponents are within 2^59 of each other, far more than any case here.
#pragma once
#include <array>

#include "culling/core/camera.h"
#include "culling/spatial/wide_bvh.h"

namespace culld::testing {

__extension__ using Quad = __float128;

struct QuadBox {
  Quad min[3], max[3];
};

/// REQUIRES: the lane is live.
inline QuadBox exactLaneBox(const WideNode& node, std::size_t lane) {
  QuadBox box;
  for (std::size_t a = 0; a < 3; ++a) {
    box.min[a] =
        static_cast<Quad>(node.origin[a]) + static_cast<Quad>(node.offsets[kMinX + a][lane]);
    box.max[a] =
        static_cast<Quad>(node.origin[a]) + static_cast<Quad>(node.offsets[kMaxX + a][lane]);
  }
  return box;
}

inline bool containsExactly(const QuadBox& outer, const Box& inner) {
  for (int a = 0; a < 3; ++a) {
    if (outer.min[a] > static_cast<Quad>(inner.min[a])) return false;
    if (outer.max[a] < static_cast<Quad>(inner.max[a])) return false;
  }
  return true;
}

inline bool containsExactly(const QuadBox& outer, const QuadBox& inner) {
  for (int a = 0; a < 3; ++a) {
    if (outer.min[a] > inner.min[a] || outer.max[a] < inner.max[a]) return false;
  }
  return true;
}

/// One clip plane of a camera: value(p) = dot(n, p - origin) + d >= 0 on the inner side.
struct QuadPlane {
  Quad n[3], d;
};

inline std::array<QuadPlane, 6> exactPlanes(const Camera& camera) {
  std::array<QuadPlane, 6> planes{};
  const auto set = [](QuadPlane& plane, const glm::dvec4& w, const glm::dvec4& row, Quad sign) {
    for (int a = 0; a < 3; ++a) {
      plane.n[a] = static_cast<Quad>(w[a]) + sign * static_cast<Quad>(row[a]);
    }
    plane.d = static_cast<Quad>(w.w) + sign * static_cast<Quad>(row.w);
  };
  set(planes[0], camera.w_row, camera.x_row, 1);
  set(planes[1], camera.w_row, camera.x_row, -1);
  set(planes[2], camera.w_row, camera.y_row, 1);
  set(planes[3], camera.w_row, camera.y_row, -1);
  set(planes[4], glm::dvec4(0.0), camera.near_cut_row, 1);
  set(planes[5], glm::dvec4(0.0), camera.far_cut_row, 1);
  return planes;
}

inline Quad quadAbs(Quad x) { return x < 0 ? -x : x; }

struct QuadValue {
  Quad value;  ///< the largest over the box
  Quad size;   ///< sum of the terms' absolute values: the quad rounding is below 2^-100 of it
};

inline QuadValue largestInBox(const QuadPlane& plane, const Camera& camera, const Box& box) {
  QuadValue result{plane.d, quadAbs(plane.d)};
  for (int a = 0; a < 3; ++a) {
    const double corner = plane.n[a] >= 0 ? box.max[a] : box.min[a];
    const Quad q = static_cast<Quad>(corner) - static_cast<Quad>(camera.origin_world[a]);
    const Quad term = plane.n[a] * q;
    result.value += term;
    result.size += quadAbs(term);
  }
  return result;
}

/// True if the whole box lies strictly outside one plane of the camera.
inline bool outsideExactly(const Camera& camera, const Box& box) {
  for (const QuadPlane& plane : exactPlanes(camera)) {
    const QuadValue v = largestInBox(plane, camera, box);
    if (v.value < v.size * static_cast<Quad>(0x1p-100)) return true;
  }
  return false;
}

/// True if the box is outside some plane by more than `share` of the terms that make up the
/// distance.
inline bool clearlyOutside(const Camera& camera, const Box& box, double share) {
  for (const QuadPlane& plane : exactPlanes(camera)) {
    const QuadValue v = largestInBox(plane, camera, box);
    if (v.value < -v.size * static_cast<Quad>(share)) return true;
  }
  return false;
}

}  // namespace culld::testing
