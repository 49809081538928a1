#include "culling/scene/gltf_document.h"

#include "culling/scene/gltf_extensions.h"

namespace culld::gltf {
namespace {

/// "2", "2.0", "2.1": anything of major version 2.
bool isMajorTwo(const std::string& version) {
  return version == "2" || version.substr(0, 2) == "2.";
}

void checkAsset(const JsonView& root) {
  const JsonView asset = root["asset"];
  if (!asset.isObject()) fail("asset", "is missing");
  const JsonView version = asset["version"];
  if (!version) fail("asset", "version is missing");
  const Place place{"asset"};
  if (!isMajorTwo(version.asText(place, "version"))) fail("asset", "version is not 2.x");
  if (asset["minVersion"] && asset.text(place, "minVersion") != "2.0") {
    fail(ErrorCode::kUnsupported, "asset: minVersion is not 2.0");
  }
}

void checkExtensions(const JsonView& root) {
  const Place place{"extensionsRequired"};
  const JsonView list = root["extensionsRequired"];
  if (list && !list.isArray()) fail("extensionsRequired", "is not an array");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < list.size(); ++i) names.push_back(list.at(i).asText(place, "a name"));
  checkRequiredExtensions(names);
}

}  // namespace

std::size_t bytesOf(Component component) noexcept {
  switch (component) {
    case Component::kInt8:
    case Component::kUint8:
      return 1;
    case Component::kInt16:
    case Component::kUint16:
      return 2;
    case Component::kUint32:
    case Component::kFloat:
      break;
  }
  return 4;
}

Document readDocument(const JsonView& root) {
  if (!root.isObject()) fail("JSON", "the root is not an object");
  checkAsset(root);
  checkExtensions(root);
  Document document;
  readData(root, document);
  readMeshes(root, document);
  readNodes(root, document);
  return document;
}

}  // namespace culld::gltf
