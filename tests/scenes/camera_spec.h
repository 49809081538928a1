// A camera as the cameras file writes it, so that a test's camera can be given to the programs.
#pragma once
#include <glm/mat4x4.hpp>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "culling/core/camera.h"

namespace culld::scenes {

/// As in cameraFromMatrices.
struct ViewProjection {
  glm::dmat4 view{1.0};
  glm::dmat4 projection{1.0};
};

struct CameraSpec {
  std::variant<LookAt, ViewProjection> pose;
  ImageSize image;
  std::string what;  ///< one word for messages, e.g. "oblique"; not in the file
};

/// ERROR: as cameraFromLookAt and cameraFromMatrices.
Result<Camera> toCamera(const CameraSpec& spec);

/// The cameras file.
std::string toJson(std::span<const CameraSpec> cameras);

}  // namespace culld::scenes
