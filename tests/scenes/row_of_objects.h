// The smallest scene with many objects.
#pragma once
#include <cstdint>

#include "culling/scene/scene_builder.h"

namespace culld::scenes {

/// `count` triangles in a row along x, a metre apart; `blocks`: do they hide anything?
inline SnapshotPtr rowOfObjects(std::uint32_t count, bool blocks = true) {
  RawSurface surface;
  surface.blocks = blocks;
  surface.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  surface.indices = {0, 1, 2};
  SceneBuilder builder;
  const MeshId mesh = builder.addMesh(makeMesh({surface}));
  for (std::uint32_t i = 0; i < count; ++i) {
    builder.addInstance(mesh, {1, 0, 0, static_cast<double>(i), 0, 1, 0, 0, 0, 0, 1, 0}, i);
  }
  return builder.finish();
}

}  // namespace culld::scenes
