#include "tests/scenes/camera_spec.h"

#include <nlohmann/json.hpp>

namespace culld::scenes {
namespace {

using Json = nlohmann::ordered_json;

Json listOf(const glm::dvec3& v) { return {v.x, v.y, v.z}; }

Json listOf(const glm::dmat4& m) {
  Json list = Json::array();
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 4; ++row) list.push_back(m[column][row]);
  }
  return list;
}

Json poseOf(const LookAt& look) {
  Json pose = {{"eye", listOf(look.eye)}, {"target", listOf(look.target)}, {"up", listOf(look.up)},
               {"yfov", look.yfov_rad},   {"aspect", look.aspect},         {"znear", look.znear_m},
               {"zfar", nullptr}};
  if (look.zfar_m) pose["zfar"] = *look.zfar_m;
  return pose;
}

Json poseOf(const ViewProjection& matrices) {
  return {{"view", listOf(matrices.view)}, {"projection", listOf(matrices.projection)}};
}

}  // namespace

Result<Camera> toCamera(const CameraSpec& spec) {
  if (const auto* look = std::get_if<LookAt>(&spec.pose)) {
    return cameraFromLookAt(*look, spec.image);
  }
  const auto& matrices = std::get<ViewProjection>(spec.pose);
  return cameraFromMatrices(matrices.view, matrices.projection, spec.image);
}

std::string toJson(std::span<const CameraSpec> cameras) {
  std::string text = "[";
  for (const CameraSpec& spec : cameras) {
    Json camera = std::visit([](const auto& pose) { return poseOf(pose); }, spec.pose);
    camera["width"] = spec.image.width_px;
    camera["height"] = spec.image.height_px;
    text += text.size() == 1 ? "\n" : ",\n";
    text += camera.dump();
  }
  return text + "\n]\n";
}

}  // namespace culld::scenes
