// Small meshes that several tests of this room build scenes from.
#pragma once
#include <array>
#include <cstdint>

#include "culling/scene/scene_builder.h"

namespace culld::test {

inline constexpr std::array<double, 12> kIdentity{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

inline std::array<double, 12> movedBy(double x, double y, double z) {
  return {1, 0, 0, x, 0, 1, 0, y, 0, 0, 1, z};
}

/// The unit cube [0,1]^3, its six sides unconnected: 24 positions, as files have it.
inline RawSurface unitCube() {
  RawSurface raw;
  for (int axis = 0; axis < 3; ++axis) {
    for (int side = 0; side < 2; ++side) {
      const auto first = static_cast<std::uint32_t>(raw.positions.size());
      for (int corner = 0; corner < 4; ++corner) {
        glm::vec3 p{0.0F};
        p[axis] = static_cast<float>(side);
        p[(axis + 1) % 3] = corner == 1 || corner == 2 ? 1.0F : 0.0F;
        p[(axis + 2) % 3] = corner >= 2 ? 1.0F : 0.0F;
        raw.positions.push_back(p);
      }
      const std::array<std::uint32_t, 6> outwards =
          side == 1 ? std::array<std::uint32_t, 6>{0, 1, 2, 0, 2, 3}
                    : std::array<std::uint32_t, 6>{0, 2, 1, 0, 3, 2};
      for (const std::uint32_t i : outwards) raw.indices.push_back(first + i);
    }
  }
  return raw;
}

/// A grid of side x side squares, two triangles each, vertices shared.
inline RawSurface gridSheet(std::uint32_t side) {
  RawSurface raw;
  for (std::uint32_t y = 0; y <= side; ++y) {
    for (std::uint32_t x = 0; x <= side; ++x) {
      raw.positions.emplace_back(static_cast<float>(x), static_cast<float>(y), 0.0F);
    }
  }
  for (std::uint32_t y = 0; y < side; ++y) {
    for (std::uint32_t x = 0; x < side; ++x) {
      const std::uint32_t a = y * (side + 1) + x, b = a + 1, c = a + side + 1, d = c + 1;
      for (const std::uint32_t i : {a, b, d, a, d, c}) raw.indices.push_back(i);
    }
  }
  return raw;
}

inline SnapshotPtr rowOfCubes(std::size_t count) {
  SceneBuilder builder;
  const MeshId cube = builder.addMesh(makeMesh({unitCube()}));
  for (std::size_t i = 0; i < count; ++i) {
    builder.addInstance(cube, movedBy(2.0 * static_cast<double>(i), 0, 0),
                        static_cast<std::uint32_t>(i));
  }
  return builder.finish();
}

}  // namespace culld::test
