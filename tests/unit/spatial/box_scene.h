// Scenes of boxes for tests: each object is an instance of a unit cube, scaled and moved, so that
// its bounds are (a rounding apart from) any box one asks for.
#pragma once
#include <array>
#include <cstdint>
#include <random>
#include <vector>

#include "culling/scene/edit.h"
#include "culling/scene/scene_builder.h"

namespace culld::testing {

/// A closed cube from (0,0,0) to (1,1,1).
inline Mesh unitCube() {
  RawSurface s;
  for (int i = 0; i < 8; ++i) {
    s.positions.emplace_back(static_cast<float>(i & 1), static_cast<float>(i >> 1 & 1),
                             static_cast<float>(i >> 2 & 1));
  }
  s.indices = {0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4,
               2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5};
  return makeMesh({s});
}

inline std::array<double, 12> placed(const glm::dvec3& low, const glm::dvec3& size) {
  return {size.x, 0, 0, low.x, 0, size.y, 0, low.y, 0, 0, size.z, low.z};
}

inline SnapshotPtr boxScene(const std::vector<std::array<double, 12>>& transforms) {
  SceneBuilder builder;
  const MeshId cube = builder.addMesh(unitCube());
  std::uint32_t node = 0;
  for (const auto& t : transforms) builder.addInstance(cube, t, node++);
  return builder.finish();
}

/// Boxes of mixed sizes within `extent` of `centre`; some lie on top of each other.
inline std::vector<std::array<double, 12>> randomBoxes(std::size_t count, const glm::dvec3& centre,
                                                       double extent, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::vector<std::array<double, 12>> boxes;
  for (std::size_t i = 0; i < count; ++i) {
    if (i % 50 == 49) {
      boxes.push_back(boxes.back());
      continue;
    }
    const auto at = [&](double c) { return c + extent * (2.0 * unit(random) - 1.0); };
    const glm::dvec3 low(at(centre.x), at(centre.y), at(centre.z));
    const double size = extent * std::pow(10.0, -4.0 * unit(random));
    boxes.push_back(placed(low, {size * unit(random), size * unit(random), size * unit(random)}));
  }
  return boxes;
}

}  // namespace culld::testing
