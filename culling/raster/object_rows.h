// From mesh space straight to cells: the camera's rows times one object's matrix, and what rounding
// may do to them. docs/error-model.md §4.1 and §4.2 prove both bounds.
#pragma once
#include <array>
#include <glm/vec3.hpp>

#include "culling/raster/cell_view.h"
#include "culling/raster/triangle_setup.h"

namespace culld {

/// One row of mesh space -> cells.
struct ObjectRow {
  double x, y, z, constant;
  double at(const glm::dvec3& p) const noexcept { return x * p.x + y * p.y + z * p.z + constant; }
};

/// All rows of CellView for one object, and the bounds on the errors of vertices made with them.
struct ObjectRows {
  ObjectRow u, v, w, n, near_cut, far_cut;
  CellVertexError error;
  CellVertex at(const glm::dvec3& p) const noexcept {
    return {u.at(p), v.at(p), w.at(p), n.at(p), near_cut.at(p), far_cut.at(p)};
  }
};

/// `largest`: of |x|, |y|, |z| over the vertices that the bounds must hold for.
ObjectRows objectRows(const CellView& view, const std::array<double, 12>& world_from_mesh,
                      const glm::dvec3& camera_origin_world, const glm::dvec3& largest) noexcept;

/// Sign of the linear part's determinant: -1 mirrors, 0 is flat or so nearly flat that rounding
/// could decide.
double handedness(const std::array<double, 12>& world_from_mesh) noexcept;

}  // namespace culld
