// What a hidden object's own triangles ask: eight at a time, which of them can be seen at all and
// in which cells; and one against the cells of one block. docs/error-model.md §5.2 proves both.
// occludee_kernels.cpp is the Highway code, occludee_reference.cpp the scalar truth; equal bytes.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "culling/raster/coverage_kernels.h"
#include "culling/raster/object_rows.h"

namespace culld {

inline constexpr std::size_t kTriangleLanes = 8;

/// Corner c of the triangle in lane l, mesh space: coordinate[3 * c + axis][l].
struct TriangleLanes {
  alignas(32) std::array<std::array<float, kTriangleLanes>, 9> coordinate;
};

/// One object under one camera.
struct OccludeeView {
  ObjectRows rows;
  double width = 0, height = 0;  ///< of the grid
  bool perspective = true;       ///< then n is 1 exactly
  bool may_be_cut = true;        ///< part of the object may lie beyond a clip plane
};

/// Per lane, clamped to the grid.
struct TriangleRects {
  alignas(32) std::array<std::uint32_t, kTriangleLanes> x0, x1, y0, y1;
  alignas(32) std::array<float, kTriangleLanes> nearest;  ///< no point of it is nearer
  /// Bit l: it surely shows nothing, as it turns away or lies beside the image, behind the eye or
  /// beyond a clip plane.
  std::uint32_t unseen = 0;
};

/// `front`: sign of the projected area of triangles that are seen; 0: they are from both sides.
/// A triangle that may reach the eye's plane gets the whole grid and infinite nearness.
void projectTriangles(const OccludeeView& view, const TriangleLanes& triangles, double front,
                      TriangleRects& out);
void projectTrianglesReference(const OccludeeView& view, const TriangleLanes& triangles,
                               double front, TriangleRects& out);

/// Over cell (i, j) of a block nothing of a triangle is nearer than a * i + b * j + c, nor than
/// `ceiling`. a, b and c are finite.
struct BlockNearest {
  float a, b, c, ceiling;
};

/// The cells that `triangle` may touch (its depth and rims are not looked at) and that do not hide
/// it. `least`: every cell is at least this near, whatever `nearness` says.
std::uint64_t cellsNotHiding(const BlockTriangle& triangle, const BlockNearest& nearest,
                             float least, const float* nearness);
std::uint64_t cellsNotHidingReference(const BlockTriangle& triangle, const BlockNearest& nearest,
                                      float least, const float* nearness);

}  // namespace culld
