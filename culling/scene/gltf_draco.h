// KHR_draco_mesh_compression: triangles and positions only.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

#include "culling/scene/gltf_budget.h"
#include "culling/scene/scene_builder.h"

namespace culld::gltf {

/// How the positions are meant, from the accessor that they stand for.
struct DracoPositions {
  std::uint32_t attribute_id = 0;
  bool normalized = false;
};

/// Fills positions and indices. Throws LoadFailure: broken stream, not the bitstream of the
/// extension, or a header that announces far more than its bytes can hold.
void decodeDraco(std::span<const std::byte> stored, const DracoPositions& wanted,
                 const Place& place, Budget& budget, RawSurface& surface);

}  // namespace culld::gltf
