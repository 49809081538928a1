#include "culling/scene/gltf_extensions.h"

#include <algorithm>
#include <string_view>

#include "culling/scene/gltf_failure.h"

namespace culld::gltf {
namespace {

/// They say where geometry is; the loader reads them.
constexpr std::string_view kRead[] = {
    "EXT_mesh_gpu_instancing",    "EXT_meshopt_compression",
    "KHR_draco_mesh_compression", "KHR_materials_diffuse_transmission",
    "KHR_materials_transmission", "KHR_materials_variants",
    "KHR_mesh_quantization",      "KHR_animation_pointer",
    "KHR_node_visibility",
};

/// They change colours, textures, lights or notes: never where geometry is or what it hides.
constexpr std::string_view kHarmless[] = {
    "EXT_lights_ies",
    "EXT_lights_image_based",
    "EXT_texture_avif",
    "EXT_texture_procedurals",
    "EXT_texture_webp",
    "KHR_lights_punctual",
    "KHR_materials_anisotropy",
    "KHR_materials_clearcoat",
    "KHR_materials_dispersion",
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_iridescence",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_sheen",
    "KHR_materials_specular",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_texture_basisu",
    "KHR_texture_transform",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "MSFT_packing_normalRoughnessMetallic",
    "MSFT_packing_occlusionRoughnessMetallic",
    "MSFT_texture_dds",
};

template <std::size_t N>
bool contains(const std::string_view (&names)[N], const std::string& name) {
  return std::find(std::begin(names), std::end(names), name) != std::end(names);
}

}  // namespace

void checkRequiredExtensions(const std::vector<std::string>& required) {
  for (const std::string& name : required) {
    if (contains(kRead, name) || contains(kHarmless, name)) continue;
    std::string shown;
    for (const char c : name.substr(0, 80)) shown += c > 0x20 && c < 0x7F ? c : '?';
    fail(ErrorCode::kUnsupported, "extensionsRequired: " + shown + " is not supported");
  }
}

}  // namespace culld::gltf
