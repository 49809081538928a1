// Materials and meshes: what is drawn, and whether it hides what is behind it.
#include "culling/scene/gltf_document.h"

namespace culld::gltf {
namespace {

/// A surface that no proof may rest on: seen from both sides, hides nothing.
constexpr Material kUncertain{false, true};

Material readMaterial(const JsonView& item, const Place& place) {
  Material material;
  const std::string alpha = item.text(place, "alphaMode");
  const JsonView extensions = item.object(place, "extensions");
  // Light comes through a transmissive surface, whatever its alphaMode says.
  material.blocks = (alpha.empty() || alpha == "OPAQUE") &&
                    !extensions["KHR_materials_transmission"] &&
                    !extensions["KHR_materials_diffuse_transmission"];
  material.double_sided = item.flagOr(place, "doubleSided", false);
  return material;
}

Material materialAt(const Document& document, std::uint32_t i) {
  return i == kNone ? Material{} : document.materials[i];
}

/// A viewer may swap materials (KHR_materials_variants): only what all of them agree on holds.
Material withVariants(Material material, const JsonView& item, const Place& place,
                      const Document& document) {
  const JsonView variants =
      item.object(place, "extensions").object(place, "KHR_materials_variants");
  const JsonView mappings = variants.array(place, "mappings");
  for (std::size_t i = 0; i < mappings.size(); ++i) {
    const std::uint32_t other =
        mappings.at(i).index(place, "material", document.materials.size(), "materials");
    const Material variant = materialAt(document, other);
    if (variant.blocks != material.blocks || variant.double_sided != material.double_sided) {
      return kUncertain;
    }
  }
  return material;
}

std::optional<DracoLink> readDraco(const JsonView& item, const Place& place,
                                   const Document& document) {
  const JsonView extension =
      item.object(place, "extensions").object(place, "KHR_draco_mesh_compression");
  if (!extension) return std::nullopt;
  DracoLink draco;
  draco.view = extension.index(place, "bufferView", document.views.size(), "bufferViews");
  if (draco.view == kNone) fail(place, "the Draco bufferView is missing");
  const JsonView attributes = extension.object(place, "attributes");
  draco.position_id = attributes.index(place, "POSITION", kNone, "attribute ids");
  return draco;
}

Primitive readPrimitive(const JsonView& item, const Place& place, const Document& document) {
  if (!item.isObject()) fail(place, "is not an object");
  Primitive primitive;
  const std::uint64_t mode = item.countOr(place, "mode", 4);
  if (mode > 6) fail(place, "unknown mode " + std::to_string(mode));
  primitive.mode = static_cast<Mode>(mode);
  const JsonView attributes = item.object(place, "attributes");
  if (!attributes) fail(place, "attributes is missing");
  const std::size_t accessors = document.accessors.size();
  primitive.positions = attributes.index(place, "POSITION", accessors, "accessors");
  primitive.indices = item.index(place, "indices", accessors, "accessors");
  const std::uint32_t material =
      item.index(place, "material", document.materials.size(), "materials");
  primitive.material = withVariants(materialAt(document, material), item, place, document);
  primitive.draco = readDraco(item, place, document);
  primitive.morphed = item.array(place, "targets").size() > 0;
  return primitive;
}

}  // namespace

void readMeshes(const JsonView& root, Document& document) {
  const JsonView materials = root["materials"];
  if (materials && !materials.isArray()) fail("materials", "is not an array");
  for (std::size_t i = 0; i < materials.size(); ++i) {
    const Place place{"material", i};
    if (!materials.at(i).isObject()) fail(place, "is not an object");
    document.materials.push_back(readMaterial(materials.at(i), place));
  }
  const JsonView meshes = root["meshes"];
  if (meshes && !meshes.isArray()) fail("meshes", "is not an array");
  for (std::size_t i = 0; i < meshes.size(); ++i) {
    const Place place{"mesh", i};
    if (!meshes.at(i).isObject()) fail(place, "is not an object");
    const JsonView primitives = meshes.at(i).array(place, "primitives");
    MeshEntry mesh;
    for (std::size_t p = 0; p < primitives.size(); ++p) {
      mesh.primitives.push_back(
          readPrimitive(primitives.at(p), {"mesh", i, "primitive", p}, document));
    }
    document.meshes.push_back(std::move(mesh));
  }
}

}  // namespace culld::gltf
