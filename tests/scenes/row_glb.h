// rowOfObjects() as a file.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/scenes/model.h"

namespace culld::scenes {

/// `count` triangles in a row along x, a metre apart, one per node.
inline std::vector<std::byte> rowGlb(std::uint32_t count) {
  Model model;
  model.addMaterial({});
  const Triangles triangle{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {0, 1, 2}};
  const auto mesh = model.addMesh({"triangle", {{triangle, 0}}});
  for (std::uint32_t i = 0; i < count; ++i) {
    model.addNode({kNone, mesh, movedBy({i, 0, 0}), ""});
  }
  return toGlb(model);
}

}  // namespace culld::scenes
