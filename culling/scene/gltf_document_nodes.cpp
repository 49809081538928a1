// Nodes and scenes: who stands where. Transforms are kept in double.
#include <string_view>

#include "culling/scene/gltf_document.h"

namespace culld::gltf {
namespace {

/// Rows from glTF's column-major 4 x 4 matrix.
Affine fromColumns(const std::array<double, 16>& m, const Place& place) {
  if (m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] != 1.0) {
    fail(place, "the last row of matrix is not 0 0 0 1");
  }
  return {m[0], m[4], m[8], m[12], m[1], m[5], m[9], m[13], m[2], m[6], m[10], m[14]};
}

Affine readTransform(const JsonView& item, const Place& place) {
  std::array<double, 16> matrix{};
  if (item.numbers(place, "matrix", matrix)) return fromColumns(matrix, place);
  std::array<double, 3> translation{0, 0, 0};
  std::array<double, 4> rotation{0, 0, 0, 1};
  std::array<double, 3> scale{1, 1, 1};
  bool moved = item.numbers(place, "translation", translation);
  moved = item.numbers(place, "rotation", rotation) || moved;
  moved = item.numbers(place, "scale", scale) || moved;
  return moved ? composeTrs(translation, rotation, scale) : Node().parent_from_node;
}

/// All attributes must agree on the count, also those that do not move instances.
std::uint32_t readInstancing(const JsonView& item, const Place& place, Document& document) {
  const JsonView extension =
      item.object(place, "extensions").object(place, "EXT_mesh_gpu_instancing");
  if (!extension) return kNone;
  const JsonView attributes = extension.object(place, "attributes");
  if (!attributes) fail(place, "EXT_mesh_gpu_instancing without attributes");
  Instancing instancing;
  bool first = true;
  for (const auto& [name, value] : attributes.members()) {
    const std::uint32_t accessor =
        value.asIndex(place, "an instance attribute", document.accessors.size(), "accessors");
    const std::uint64_t count = document.accessors[accessor].count;
    if (!first && count != instancing.count) {
      fail(place, "instance attributes of " + std::to_string(instancing.count) + " and " +
                      std::to_string(count) + " elements");
    }
    first = false;
    instancing.count = count;
    if (name == "TRANSLATION") instancing.translation = accessor;
    if (name == "ROTATION") instancing.rotation = accessor;
    if (name == "SCALE") instancing.scale = accessor;
  }
  if (first) fail(place, "EXT_mesh_gpu_instancing without attributes");
  document.instancings.push_back(instancing);
  return static_cast<std::uint32_t>(document.instancings.size() - 1);
}

/// A viewer may show something else here than what the file says at rest.
bool mayChange(const JsonView& item, const Place& place) {
  const JsonView extensions = item.object(place, "extensions");
  const JsonView visibility = extensions.object(place, "KHR_node_visibility");
  return !visibility.flagOr(place, "visible", true) || extensions["MSFT_lod"];
}

Node readNode(const JsonView& item, const Place& place, std::size_t node_count,
              std::size_t skin_count, Document& document) {
  if (!item.isObject()) fail(place, "is not an object");
  Node node;
  node.parent_from_node = readTransform(item, place);
  node.mesh = item.index(place, "mesh", document.meshes.size(), "meshes");
  node.restless = item.index(place, "skin", skin_count, "skins") != kNone || mayChange(item, place);
  node.instancing = readInstancing(item, place, document);
  const JsonView children = item.array(place, "children");
  node.first_child = static_cast<std::uint32_t>(document.children.size());
  node.child_count = static_cast<std::uint32_t>(children.size());
  for (std::size_t c = 0; c < children.size(); ++c) {
    document.children.push_back(children.at(c).asIndex(place, "child", node_count, "nodes"));
  }
  return node;
}

std::vector<std::uint32_t> nodesWithoutParent(const Document& document) {
  std::vector<bool> is_child(document.nodes.size());
  for (const std::uint32_t child : document.children) is_child[child] = true;
  std::vector<std::uint32_t> roots;
  for (std::uint32_t n = 0; n < document.nodes.size(); ++n) {
    if (!is_child[n]) roots.push_back(n);
  }
  return roots;
}

/// Roots of the scene that is shown: `scene`, else the first, else everything there is.
std::vector<std::uint32_t> defaultRoots(const JsonView& root, const Document& document) {
  const JsonView scenes = root["scenes"];
  if (scenes && !scenes.isArray()) fail("scenes", "is not an array");
  const JsonView chosen = root["scene"];
  std::uint32_t scene = 0;
  if (chosen) {
    if (scenes.size() == 0) fail("scene", "chosen, but there are no scenes");
    scene = chosen.asIndex({"default scene"}, "scene", scenes.size(), "scenes");
  }
  if (scenes.size() == 0) return nodesWithoutParent(document);
  const Place place{"scene", scene};
  if (!scenes.at(scene).isObject()) fail(place, "is not an object");
  const JsonView nodes = scenes.at(scene).array(place, "nodes");
  std::vector<std::uint32_t> roots;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    roots.push_back(nodes.at(i).asIndex(place, "node", document.nodes.size(), "nodes"));
  }
  return roots;
}

/// The node that "/nodes/7/translation" (KHR_animation_pointer) names, or kNone.
std::uint32_t nodeOfPointer(const std::string& pointer, std::size_t node_count) {
  constexpr std::string_view kNodes = "/nodes/";
  if (!pointer.starts_with(kNodes)) return kNone;
  std::uint64_t n = 0;
  for (std::size_t i = kNodes.size(); i < pointer.size() && pointer[i] != '/'; ++i) {
    if (pointer[i] < '0' || pointer[i] > '9' || n >= node_count) return kNone;
    n = 10 * n + static_cast<std::uint64_t>(pointer[i] - '0');
  }
  return n < node_count ? static_cast<std::uint32_t>(n) : kNone;
}

/// Nodes that an animation moves have no bounds that hold.
void markAnimated(const JsonView& root, Document& document) {
  const JsonView animations = root.array({"animations"}, "animations");
  for (std::size_t a = 0; a < animations.size(); ++a) {
    const Place place{"animation", a};
    const JsonView channels = animations.at(a).array(place, "channels");
    for (std::size_t c = 0; c < channels.size(); ++c) {
      const JsonView target = channels.at(c).object(place, "target");
      std::uint32_t node = target.index(place, "node", document.nodes.size(), "nodes");
      const JsonView pointer =
          target.object(place, "extensions").object(place, "KHR_animation_pointer");
      if (pointer) node = nodeOfPointer(pointer.text(place, "pointer"), document.nodes.size());
      if (node != kNone) document.nodes[node].restless = true;
    }
  }
}

}  // namespace

Affine composeTrs(const std::array<double, 3>& t, const std::array<double, 4>& q,
                  const std::array<double, 3>& s) {
  const double x = q[0];
  const double y = q[1];
  const double z = q[2];
  const double w = q[3];
  const std::array<double, 9> r = {
      1 - 2 * (y * y + z * z), 2 * (x * y - z * w),     2 * (x * z + y * w),
      2 * (x * y + z * w),     1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
      2 * (x * z - y * w),     2 * (y * z + x * w),     1 - 2 * (x * x + y * y)};
  return {r[0] * s[0], r[1] * s[1], r[2] * s[2], t[0],        r[3] * s[0], r[4] * s[1],
          r[5] * s[2], t[1],        r[6] * s[0], r[7] * s[1], r[8] * s[2], t[2]};
}

Affine multiply(const Affine& a, const Affine& b) {
  Affine c{};
  for (std::size_t row = 0; row < 3; ++row) {
    const double* r = &a[4 * row];
    for (std::size_t col = 0; col < 4; ++col) {
      const double moved = col == 3 ? r[3] : 0.0;
      c[4 * row + col] = r[0] * b[col] + r[1] * b[4 + col] + r[2] * b[8 + col] + moved;
    }
  }
  return c;
}

void readNodes(const JsonView& root, Document& document) {
  const JsonView nodes = root["nodes"];
  if (nodes && !nodes.isArray()) fail("nodes", "is not an array");
  const JsonView skins = root["skins"];
  if (skins && !skins.isArray()) fail("skins", "is not an array");
  document.nodes.reserve(nodes.size());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    document.nodes.push_back(
        readNode(nodes.at(i), {"node", i}, nodes.size(), skins.size(), document));
  }
  markAnimated(root, document);
  document.roots = defaultRoots(root, document);
}

}  // namespace culld::gltf
