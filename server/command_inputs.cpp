#include "server/command_inputs.h"

#include <unistd.h>

#include <cstdio>
#include <utility>

#include "culling/scene/gltf_loader.h"
#include "server/translate.h"

namespace culld {

ProgressBar::ProgressBar(std::string what) : what_(std::move(what)), shown_(isatty(2) == 1) {}

ProgressBar::~ProgressBar() {
  if (percent_ >= 0) std::fputs("\r\033[K", stderr);
}

void ProgressBar::show(std::size_t done, std::size_t total) {
  constexpr int kWidth = 40;
  const int percent = total == 0 ? 100 : static_cast<int>(done * 100 / total);
  if (!shown_ || percent <= percent_) return;
  percent_ = percent;
  const auto filled = static_cast<std::size_t>(percent * kWidth / 100);
  const std::string bar = std::string(filled, '#') + std::string(kWidth - filled, '.');
  std::fprintf(stderr, "\r%s [%s] %3d%%", what_.c_str(), bar.c_str(), percent);
}

Result<SnapshotPtr> loadScene(const std::string& path) {
  ProgressBar bar("loading " + path);
  LoadOptions options;
  options.progress = [&bar](std::size_t done, std::size_t total) { bar.show(done, total); };
  return loadGltfFile(path, options);
}

Result<std::vector<Camera>> readCameras(const std::string& path, protocol::ImageSize image) {
  const auto read = protocol::readCameraFile(path, image);
  if (!read) return invalidInput(read.error().message);
  std::vector<Camera> cameras;
  for (std::size_t i = 0; i < read.value().size(); ++i) {
    auto camera = server::toEngine(read.value()[i]);
    if (!camera) {
      std::string what = camera.error().message;
      if (what.rfind("camera: ", 0) == 0) what.erase(0, 8);
      return invalidInput(path + ": camera " + std::to_string(i) + ": " + what);
    }
    cameras.push_back(camera.value());
  }
  return cameras;
}

}  // namespace culld
