#include "tests/bench/dump_scene.h"

#include <cmath>
#include <glm/mat4x4.hpp>

#include "culling/scene/scene_builder.h"

namespace culld::bench {
namespace {

Mesh unitBox() {
  RawSurface box;
  for (std::uint32_t v = 0; v < 8; ++v) {
    box.positions.emplace_back(v & 1U ? 1.0F : 0.0F, v & 2U ? 1.0F : 0.0F, v & 4U ? 1.0F : 0.0F);
  }
  box.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
                 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  box.blocks = false;
  return makeMesh({box});
}

Mesh occluder(const Dump& dump, const DumpMesh& part) {
  RawSurface surface;
  for (std::uint32_t i = 0; i < part.index_count; ++i) {
    const auto& p = dump.vertices[dump.indices[part.first_index + i]];
    surface.positions.emplace_back(p[0], p[1], p[2]);
    surface.indices.push_back(i);
  }
  return makeMesh({surface});
}

glm::dmat4 matrix(const std::array<float, 16>& m) {
  glm::dmat4 out;
  for (std::size_t i = 0; i < 16; ++i) {
    out[static_cast<glm::length_t>(i / 4)][static_cast<glm::length_t>(i % 4)] =
        static_cast<double>(m[i]);
  }
  return out;
}

}  // namespace

SnapshotPtr toSnapshot(const Dump& dump) {
  SceneBuilder builder;
  const MeshId box = builder.addMesh(unitBox());
  std::uint32_t node = 0;
  for (const DumpBox& b : dump.objects) {
    std::array<double, 12> rows{};
    for (std::size_t a = 0; a < 3; ++a) {
      rows[4 * a + a] = static_cast<double>(b.max[a]) - static_cast<double>(b.min[a]);
      rows[4 * a + 3] = static_cast<double>(b.min[a]);
    }
    builder.addInstance(box, rows, node++);
  }
  for (const DumpMesh& mesh : dump.meshes) {
    const MeshId id = builder.addMesh(occluder(dump, mesh));
    builder.addInstance(id, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, node++);
  }
  return builder.finish();
}

Result<Camera> toCamera(const DumpCamera& camera, ImageSize image) {
  return cameraFromMatrices(matrix(camera.view), matrix(camera.projection), image);
}

std::uint32_t scanBoxes(const std::vector<DumpBox>& boxes, const DumpCamera& camera) {
  const auto& m = camera.view_projection;
  std::array<std::array<float, 4>, 6> planes{};
  for (std::size_t p = 0; p < 6; ++p) {
    const float sign = p % 2 == 0 ? 1.0F : -1.0F;
    for (std::size_t i = 0; i < 4; ++i) planes[p][i] = m[4 * i + 3] + sign * m[4 * i + p / 2];
  }
  std::uint32_t inside = 0;
  for (const DumpBox& box : boxes) {
    bool out = false;
    for (const auto& plane : planes) {
      float value = plane[3];
      for (std::size_t a = 0; a < 3; ++a) {
        value += plane[a] * (plane[a] >= 0.0F ? box.max[a] : box.min[a]);
      }
      if (value < 0.0F) {
        out = true;
        break;
      }
    }
    if (!out) ++inside;
  }
  return inside;
}

}  // namespace culld::bench
