// Content hashes: XXH3 over fields written one by one, never over struct padding.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "culling/scene/mesh.h"
#include "culling/scene/scene_snapshot.h"

namespace culld {

/// Of what the mesh looks like; partners follow from the triangles.
std::uint64_t hashMesh(const Mesh& mesh);

/// Of what edits can change and what identifies an object. A removed object counts as removed and
/// nothing else, whatever it was before.
std::uint64_t hashInstances(std::span<const Instance> instances);

/// Of a list of hashes, in order.
std::uint64_t hashTogether(std::span<const std::uint64_t> hashes);

}  // namespace culld
