#include "culling/scene/gltf_nodes.h"

#include <algorithm>

namespace culld::gltf {
namespace {

using Parents = std::vector<std::uint32_t>;

Parents findParents(const Document& document) {
  Parents parents(document.nodes.size(), kNone);
  for (std::uint32_t n = 0; n < document.nodes.size(); ++n) {
    const Node& node = document.nodes[n];
    for (std::uint32_t c = 0; c < node.child_count; ++c) {
      const std::uint32_t child = document.children[node.first_child + c];
      if (parents[child] != kNone) {
        fail(Place{"node", child}, "has two parents, nodes " + std::to_string(parents[child]) +
                                       " and " + std::to_string(n));
      }
      parents[child] = n;
    }
  }
  return parents;
}

/// With one parent each, a node is on or below a cycle when no root is above it.
void refuseCycles(const Parents& parents) {
  enum : unsigned char { kUnknown, kOnPath, kRooted };
  std::vector<unsigned char> state(parents.size(), kUnknown);
  std::vector<std::uint32_t> path;
  for (std::uint32_t start = 0; start < parents.size(); ++start) {
    path.clear();
    std::uint32_t n = start;
    while (n != kNone && state[n] == kUnknown) {
      state[n] = kOnPath;
      path.push_back(n);
      n = parents[n];
    }
    if (n != kNone && state[n] == kOnPath) fail(Place{"node", n}, "is its own ancestor");
    for (const std::uint32_t seen : path) state[seen] = kRooted;
  }
}

void refuseBadRoots(const Document& document, const Parents& parents) {
  std::vector<bool> listed(document.nodes.size());
  for (const std::uint32_t root : document.roots) {
    if (parents[root] != kNone) {
      fail(Place{"node", root},
           "is a root of the scene and a child of node " + std::to_string(parents[root]));
    }
    if (listed[root]) fail(Place{"node", root}, "is listed twice as a root of the scene");
    listed[root] = true;
  }
}

void placeBelow(const Document& document, std::uint32_t root, std::vector<PlacedNode>& placed) {
  const Node& top = document.nodes[root];
  std::vector<PlacedNode> open = {{root, top.parent_from_node, top.restless}};
  while (!open.empty()) {
    const PlacedNode here = open.back();
    open.pop_back();
    const Node& node = document.nodes[here.node];
    if (node.mesh != kNone) placed.push_back(here);
    for (std::uint32_t c = 0; c < node.child_count; ++c) {
      const std::uint32_t child = document.children[node.first_child + c];
      const Node& below = document.nodes[child];
      open.push_back({child, multiply(here.world_from_node, below.parent_from_node),
                      here.restless || below.restless});
    }
  }
}

}  // namespace

std::vector<PlacedNode> placeNodes(const Document& document) {
  const Parents parents = findParents(document);
  refuseCycles(parents);
  refuseBadRoots(document, parents);

  std::vector<PlacedNode> placed;
  for (const std::uint32_t root : document.roots) placeBelow(document, root, placed);
  std::sort(placed.begin(), placed.end(),
            [](const PlacedNode& a, const PlacedNode& b) { return a.node < b.node; });
  return placed;
}

}  // namespace culld::gltf
