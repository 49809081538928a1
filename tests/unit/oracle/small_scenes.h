// Words to build small scenes with: boxes and walls, one object each.
#pragma once
#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "culling/core/camera.h"
#include "culling/scene/scene_builder.h"

namespace culld::oracle_test {

using Rows = std::array<double, 12>;

inline Rows at(double x, double y, double z, double sx = 1, double sy = 1, double sz = 1) {
  return {sx, 0, 0, x, 0, sy, 0, y, 0, 0, sz, z};
}

/// A unit square in the plane z = 0 around the origin, its front towards +z.
inline RawSurface wall(bool blocks = true, bool double_sided = false) {
  return {{{-0.5F, -0.5F, 0}, {0.5F, -0.5F, 0}, {0.5F, 0.5F, 0}, {-0.5F, 0.5F, 0}},
          {0, 1, 2, 0, 2, 3},
          blocks,
          double_sided};
}

/// A unit cube around the origin, closed, its fronts outwards.
inline RawSurface cube() {
  RawSurface cube;
  for (int i = 0; i < 8; ++i) {
    cube.positions.emplace_back((i & 1) != 0 ? 0.5F : -0.5F, (i & 2) != 0 ? 0.5F : -0.5F,
                                (i & 4) != 0 ? 0.5F : -0.5F);
  }
  cube.indices = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 4, 6, 0, 6, 2,
                  1, 3, 7, 1, 7, 5, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3};
  return cube;
}

class Scene {
 public:
  ObjectId add(const RawSurface& surface, const Rows& rows) {
    return add(std::vector{surface}, rows);
  }
  ObjectId add(const std::vector<RawSurface>& surfaces, const Rows& rows) {
    const MeshId mesh = builder_.addMesh(makeMesh(surfaces));
    return builder_.addInstance(mesh, rows, next_++);
  }
  SnapshotPtr finish() { return builder_.finish(); }

 private:
  SceneBuilder builder_;
  std::uint32_t next_ = 0;
};

/// At `eye`, looking down -z.
inline Camera cameraAt(const glm::dvec3& eye, ImageSize image = {160, 90}, double near = 0.1) {
  LookAt look;
  look.eye = eye;
  look.target = eye + glm::dvec3(0, 0, -1);
  look.znear_m = near;
  auto camera = cameraFromLookAt(look, image);
  return camera.value();
}

}  // namespace culld::oracle_test
