// The scalar truth of occludee_kernels.h, in the same order of operations as the kernels.
#include <algorithm>
#include <cmath>
#include <limits>

#include "culling/raster/occludee_kernels.h"

namespace culld {
namespace {

constexpr double kUnit = 0x1p-53;     // half an ulp of 1
constexpr double kTiny = 1e-280;      // below it, underflow could exceed the error bounds
constexpr double kHuge = 1e280;       // beyond it, products could overflow
constexpr double kFarBeside = 1e15;   // cells; farther away, places are not to be trusted
constexpr double kPad = 1e-9;         // cells
constexpr double kToFloat = 0x1p-22;  // more than a float's rounding takes
constexpr double kSubnormal = 1e-37;  // the same, where floats lose digits
constexpr double kLargest = 3e38;     // about the largest float
constexpr float kInfinity = std::numeric_limits<float>::infinity();

struct Corner {
  double u, v, w;
};

/// Running bounds over the corners of one triangle.
struct Bounds {
  double x0 = 1e300, x1 = -1e300, y0 = 1e300, y1 = -1e300, nearest = 0.0;
  bool bounded = true, behind = true;
};

void addCorner(const OccludeeView& view, const Corner& p, double n, Bounds& b) {
  const CellVertexError& e = view.rows.error;
  const double least_w = p.w - e.w;
  const bool in_front = least_w > 0.5 * p.w && least_w > kTiny;
  b.behind = b.behind && p.w + e.w < 0.0;
  const double r = 1.0 / p.w;
  const double x = p.u * r, y = p.v * r;
  const double ex = ((e.u + std::abs(x) * e.w) * r) * 2.1 + (std::abs(x) * (8.0 * kUnit) + kPad);
  const double ey = ((e.v + std::abs(y) * e.w) * r) * 2.1 + (std::abs(y) * (8.0 * kUnit) + kPad);
  const bool in_range = std::abs(x) + ex < kFarBeside && std::abs(y) + ey < kFarBeside && n < kHuge;
  b.bounded = b.bounded && in_front && in_range;
  b.x0 = std::min(b.x0, x - ex);
  b.x1 = std::max(b.x1, x + ex);
  b.y0 = std::min(b.y0, y - ey);
  b.y1 = std::max(b.y1, y + ey);
  const double near = (std::max(n, 0.0) * r) * (1.0 + (e.w * r) * 2.1);
  b.nearest = std::max(b.nearest, near);
}

bool turnsAway(const std::array<Corner, 3>& p, const CellVertexError& e, double front) {
  const double a = p[1].v * p[2].w - p[1].w * p[2].v;
  const double b = p[1].w * p[2].u - p[1].u * p[2].w;
  const double c = p[1].u * p[2].v - p[1].v * p[2].u;
  const double det = (p[0].u * a + p[0].v * b) + p[0].w * c;
  const auto largest = [](double x, double y, double z) {
    return std::max(std::max(std::abs(x), std::abs(y)), std::abs(z));
  };
  const double mu = largest(p[0].u, p[1].u, p[2].u) + e.u;
  const double mv = largest(p[0].v, p[1].v, p[2].v) + e.v;
  const double mw = largest(p[0].w, p[1].w, p[2].w) + e.w;
  const double spread = (e.u * mv) * mw + mu * (e.v * mw + mv * e.w);
  const double error = spread * 8.0 + ((mu + mv) + (mw + 1.0)) * kTiny;
  return det * front < -error && (mu * mv) * mw < kHuge;
}

bool allBelow(const std::array<double, 3>& k, double limit) {
  return k[0] < limit && k[1] < limit && k[2] < limit;
}

std::uint32_t cell(double x, double side) {
  return static_cast<std::uint32_t>(std::min(std::max(x, 0.0), side - 1.0));
}

void projectLane(const OccludeeView& view, const TriangleLanes& triangles, double front,
                 std::size_t lane, TriangleRects& out) {
  const ObjectRows& rows = view.rows;
  std::array<Corner, 3> corner{};
  std::array<double, 3> near_cut{}, far_cut{};
  Bounds b;
  for (std::size_t c = 0; c < 3; ++c) {
    const glm::dvec3 p(triangles.coordinate[3 * c][lane], triangles.coordinate[3 * c + 1][lane],
                       triangles.coordinate[3 * c + 2][lane]);
    corner[c] = {rows.u.at(p), rows.v.at(p), rows.w.at(p)};
    addCorner(view, corner[c], view.perspective ? 1.0 : rows.n.at(p) + rows.error.n, b);
    near_cut[c] = rows.near_cut.at(p);
    far_cut[c] = rows.far_cut.at(p);
  }
  const bool beside =
      b.bounded && (b.x1 < 0.0 || b.x0 > view.width || b.y1 < 0.0 || b.y0 > view.height);
  const bool cut = view.may_be_cut && (allBelow(near_cut, -rows.error.near_cut) ||
                                       allBelow(far_cut, -rows.error.far_cut));
  const bool unseen = beside || b.behind || cut || turnsAway(corner, rows.error, front);
  if (unseen) out.unseen |= 1U << lane;
  out.x0[lane] = cell(b.bounded ? b.x0 : 0.0, view.width);
  out.x1[lane] = cell(b.bounded ? b.x1 : view.width, view.width);
  out.y0[lane] = cell(b.bounded ? b.y0 : 0.0, view.height);
  out.y1[lane] = cell(b.bounded ? b.y1 : view.height, view.height);
  const double raised = b.nearest * (1.0 + kToFloat) + kSubnormal;
  out.nearest[lane] = b.bounded && raised < kLargest ? static_cast<float>(raised) : kInfinity;
}

}  // namespace

void projectTrianglesReference(const OccludeeView& view, const TriangleLanes& triangles,
                               double front, TriangleRects& out) {
  out.unseen = 0;
  for (std::size_t lane = 0; lane < kTriangleLanes; ++lane) {
    projectLane(view, triangles, front, lane, out);
  }
}

std::uint64_t cellsNotHidingReference(const BlockTriangle& t, const BlockNearest& nearest,
                                      float least, const float* nearness) {
  std::uint64_t open = 0;
  for (std::uint32_t j = 0; j < 8; ++j) {
    for (std::uint32_t i = 0; i < 8; ++i) {
      bool touched = true;
      for (std::uint32_t s = 0; s < t.sides; ++s) {
        const float row = t.c[s] + t.b[s] * static_cast<float>(j);
        touched = touched && t.a[s] * static_cast<float>(i) + row >= t.touch[s];
      }
      const float plane_row = nearest.c + nearest.b * static_cast<float>(j);
      const float plane = nearest.a * static_cast<float>(i) + plane_row;
      const float limit = std::max(std::min(plane, nearest.ceiling), 0.0F);
      const bool hidden = std::max(nearness[8 * j + i], least) > limit;
      if (touched && !hidden) open |= std::uint64_t{1} << (8 * j + i);
    }
  }
  return open;
}

}  // namespace culld
