// From primitives of a glTF mesh to one culld mesh.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/scene/gltf_data.h"
#include "culling/scene/mesh.h"

namespace culld::gltf {

/// Accessors that decodeMesh will read.
std::vector<std::uint32_t> accessorsOf(const MeshEntry& mesh);

/// Throws LoadFailure naming mesh and primitive. THREADS: any.
Mesh decodeMesh(const DataSource& data, std::uint32_t mesh, Budget& budget);

}  // namespace culld::gltf
