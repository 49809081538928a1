// A scene, its cameras and somebody's answers, brought together: nodes of the file become objects.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <unordered_map>
#include <unordered_set>

#include "culling/scene/gltf_loader.h"
#include "protocol/camera_file.h"
#include "server/translate.h"
#include "tests/bench/checked_frame.h"

namespace culld::bench {
namespace {

using nlohmann::json;

/// From node and instance number to object.
class Objects {
 public:
  explicit Objects(const SceneSnapshot& scene) {
    for (ObjectId id = 0; id < scene.objectCount(); ++id) {
      const Instance& instance = scene.instance(id);
      nodes_[instance.node].emplace_back(instance.instance_number, id);
    }
  }
  /// Empty if there is no such node.
  std::vector<ObjectId> ofNode(std::uint32_t node) const {
    std::vector<ObjectId> ids;
    const auto at = nodes_.find(node);
    if (at == nodes_.end()) return ids;
    for (const auto& [number, id] : at->second) ids.push_back(id);
    return ids;
  }
  std::vector<ObjectId> ofInstances(std::uint32_t node,
                                    const std::vector<std::uint32_t>& numbers) const {
    std::vector<ObjectId> ids;
    const auto at = nodes_.find(node);
    if (at == nodes_.end()) return ids;
    const std::unordered_set<std::uint32_t> wanted(numbers.begin(), numbers.end());
    for (const auto& [number, id] : at->second) {
      if (wanted.contains(number)) ids.push_back(id);
    }
    return ids;
  }

 private:
  std::unordered_map<std::uint32_t, std::vector<std::pair<std::uint32_t, ObjectId>>> nodes_;
};

Result<AnsweredFrame> readFrame(const json& text, const Objects& objects, std::size_t cameras) {
  AnsweredFrame frame;
  frame.camera = text.at("camera").get<std::size_t>();
  const std::string place = "camera " + std::to_string(frame.camera);
  if (frame.camera >= cameras) return invalidInput(place + " is not in the cameras file");
  const json instances = text.value("instances", json::object());
  for (const json& entry : text.at("visible")) {
    const auto node = entry.get<std::uint32_t>();
    const auto chosen = instances.find(std::to_string(node));
    const std::vector<ObjectId> ids =
        chosen == instances.end()
            ? objects.ofNode(node)
            : objects.ofInstances(node, chosen->get<std::vector<std::uint32_t>>());
    if (ids.empty() || (chosen != instances.end() && ids.size() != chosen->size())) {
      return invalidInput(place + ": node " + std::to_string(node) + " is not in the scene");
    }
    frame.visible.insert(frame.visible.end(), ids.begin(), ids.end());
  }
  std::sort(frame.visible.begin(), frame.visible.end());
  frame.visible.erase(std::unique(frame.visible.begin(), frame.visible.end()), frame.visible.end());
  return frame;
}

Result<void> readAnswers(const std::string& path, Inputs& inputs) {
  std::ifstream file(path);
  if (!file) return Error{ErrorCode::kIo, path + ": cannot read"};
  try {
    const json text = json::parse(file);
    inputs.method = text.at("method").get<std::string>();
    inputs.guarantee = text.at("guarantee").get<std::string>();
    const Objects objects(*inputs.scene);
    for (const json& entry : text.at("frames")) {
      auto frame = readFrame(entry, objects, inputs.cameras.size());
      if (!frame) return invalidInput(path + ": " + frame.error().message);
      inputs.frames.push_back(std::move(frame).value());
    }
  } catch (const json::exception& error) {
    return invalidInput(path + ": not an answers file: " + error.what());
  }
  return Done{};
}

}  // namespace

Result<Inputs> readInputs(const std::string& scene, const std::string& cameras,
                          const std::string& answers) {
  Inputs inputs;
  inputs.name = std::filesystem::path(scene).filename().string();
  auto loaded = loadGltfFile(scene);
  if (!loaded) return std::move(loaded).error();
  inputs.scene = std::move(loaded).value();
  const auto poses = protocol::readCameraFile(cameras);
  if (!poses) return invalidInput(poses.error().message);
  for (std::size_t i = 0; i < poses.value().size(); ++i) {
    auto camera = server::toEngine(poses.value()[i]);
    if (!camera) {
      return invalidInput(cameras + ": camera " + std::to_string(i) + ": " +
                          camera.error().message);
    }
    inputs.cameras.push_back(camera.value());
  }
  if (auto read = readAnswers(answers, inputs); !read) return std::move(read).error();
  return inputs;
}

}  // namespace culld::bench
