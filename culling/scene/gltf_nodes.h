// The node tree of the default scene, walked without recursion.
#pragma once
#include <cstdint>
#include <vector>

#include "culling/scene/gltf_document.h"

namespace culld::gltf {

struct PlacedNode {
  std::uint32_t node = 0;
  Affine world_from_node{};
  bool restless = false;  ///< the node or one above it
};

/// Nodes of the default scene that carry a mesh, in the order of their numbers.
/// Throws LoadFailure: a node with two parents, a cycle, a root that is listed twice or is
/// somebody's child.
std::vector<PlacedNode> placeNodes(const Document& document);

}  // namespace culld::gltf
