#include "culling/raster/box_probe.h"

#include <algorithm>
#include <cmath>

#include "culling/raster/object_rows.h"
#include "culling/raster/triangle_setup.h"

namespace culld {
namespace {

/// What evaluating a side in double may lose, in cells; generous.
constexpr double kSideMargin = 0x1p-12, kSideUnit = 0x1p-48;

/// A face's corners, CCW from outside. Corner c has the box's far end on axis i if bit i is set.
using Face = std::array<std::uint8_t, 4>;
constexpr std::array<Face, 6> kFaces{
    {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}}};

/// Each edge once: the faces at it, and which edge of the first it is.
struct BoxEdge {
  std::uint8_t face, beside, first;
};
constexpr std::array<BoxEdge, 12> kEdges{{{0, 2, 0},
                                          {0, 5, 1},
                                          {0, 3, 2},
                                          {0, 4, 3},
                                          {1, 4, 0},
                                          {1, 3, 1},
                                          {1, 5, 2},
                                          {1, 2, 3},
                                          {2, 4, 0},
                                          {2, 5, 2},
                                          {3, 5, 1},
                                          {3, 4, 3}}};

class ProjectedBox {
 public:
  ProjectedBox(const CellView& view, const glm::dvec3& camera_origin_world,
               const std::array<double, 3>& origin, BoxOffsets offsets, std::size_t lane)
      : grid_{static_cast<double>(view.grid.width), static_cast<double>(view.grid.height)} {
    glm::dvec3 low, high;
    for (std::size_t i = 0; i < 3; ++i) {
      low[static_cast<int>(i)] = static_cast<double>(offsets[i][lane]);
      high[static_cast<int>(i)] = static_cast<double>(offsets[i + 3][lane]);
    }
    const glm::dvec3 largest = glm::max(glm::abs(low), glm::abs(high));
    const ObjectRows rows =
        objectRows(view, {1, 0, 0, origin[0], 0, 1, 0, origin[1], 0, 0, 1, origin[2]},
                   camera_origin_world, largest);
    error_ = rows.error;
    error_.motion = EyeMotion{};  // boxes are looked up as the still eye sees them
    for (std::uint32_t c = 0; c < 8; ++c) {
      corners_[c] = rows.at({(c & 1U) != 0 ? high.x : low.x, (c & 2U) != 0 ? high.y : low.y,
                             (c & 4U) != 0 ? high.z : low.z});
    }
    for (std::size_t f = 0; f < kFaces.size(); ++f) orientFace(f, view.front_sign);
  }

  /// Half-planes that contain the whole box: along its edges between front and back faces.
  void addSides(BoxProbe& probe) const {
    for (const BoxEdge& edge : kEdges) {
      const bool silhouette = facing_[edge.face] * facing_[edge.beside] < 0;
      if (!silhouette || probe.side_count == BoxProbe::kMostSides) continue;
      const CellVertex& p = corners_[kFaces[edge.face][edge.first]];
      const CellVertex& q = corners_[kFaces[edge.face][(edge.first + 1U) % 4U]];
      // All of the box lies on the side of the edge on which the face lies.
      const int orientation = oriented_[edge.face].orientation;
      const SideLine side = sideOf(p, q, lineThrough(p, q, error_), error_, grid_, orientation);
      if (!side.usable()) continue;
      const double margin = side.error + kSideMargin + kSideUnit * std::abs(side.c);
      probe.sides[probe.side_count++] = {side.a, side.b, side.c + margin};
    }
  }

  void addFrontFaces(BoxProbe& probe) const {
    for (std::size_t f = 0; f < kFaces.size(); ++f) {
      if (facing_[f] <= 0 || probe.face_count == BoxProbe::kMostFaces) continue;
      probe.faces[probe.face_count++] =
          nearestPlane(threeOf(f), error_, grid_, oriented_[f], probe.nearest);
    }
  }

 private:
  std::array<CellVertex, 3> threeOf(std::size_t face) const {
    return {corners_[kFaces[face][0]], corners_[kFaces[face][1]], corners_[kFaces[face][2]]};
  }

  void orientFace(std::size_t face, double front_sign) {
    const auto [p, q, r] = threeOf(face);
    oriented_[face] = orientTriangle(p, q, r, error_, grid_, 0);
    facing_[face] = oriented_[face].orientation * static_cast<int>(front_sign);
  }

  GridSize grid_;
  CellVertexError error_;
  std::array<CellVertex, 8> corners_;
  std::array<OrientedTriangle, 6> oriented_;
  std::array<int, 6> facing_{};  ///< +1 surely turned to the eye, -1 surely away, 0 not known
};

}  // namespace

bool BoxProbe::besides(const CellRect& cells) const noexcept {
  const double u0 = cells.x0, u1 = cells.x1 + 1.0, v0 = cells.y0, v1 = cells.y1 + 1.0;
  for (std::uint32_t s = 0; s < side_count; ++s) {
    const Side& side = sides[s];
    const double most =
        side.a * (side.a > 0.0 ? u1 : u0) + side.b * (side.b > 0.0 ? v1 : v0) + side.c;
    if (most < 0.0) return true;
  }
  return false;
}

float BoxProbe::nearestOver(const CellRect& cells) const noexcept {
  const double u0 = cells.x0, u1 = cells.x1 + 1.0, v0 = cells.y0, v1 = cells.y1 + 1.0;
  float near = nearest;
  for (std::uint32_t f = 0; f < face_count; ++f) {
    near = std::min(near, faces[f].over(u0, u1, v0, v1));
  }
  return near;
}

void addFaces(const CellView& view, const glm::dvec3& camera_origin_world,
              const std::array<double, 3>& origin_world, BoxOffsets offsets, std::size_t lane,
              BoxProbe& probe) {
  if (!std::isfinite(probe.nearest) || view.front_sign == 0.0) return;
  const ProjectedBox box(view, camera_origin_world, origin_world, offsets, lane);
  box.addSides(probe);
  box.addFrontFaces(probe);
}

}  // namespace culld
