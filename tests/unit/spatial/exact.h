// Exact sums for tests. __float128 has 113 bits: a double (53) plus or minus a float (24) is exact
// in it while their exponents are within 2^59 of each other, far more than any case here.
#pragma once
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

}  // namespace culld::testing
