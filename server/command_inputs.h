// What commands read before they work: scenes and cameras, with progress on the terminal.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "culling/core/camera.h"
#include "culling/scene/scene_snapshot.h"
#include "protocol/camera_file.h"

namespace culld {

/// A bar on the terminal while something lasts; silent when stderr is a file or a pipe.
class ProgressBar {
 public:
  explicit ProgressBar(std::string what);  ///< "loading city.glb"
  ~ProgressBar();
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;
  void show(std::size_t done, std::size_t total);

 private:
  std::string what_;
  bool shown_;
  int percent_ = -1;
};

/// ERROR: naming file and place.
Result<SnapshotPtr> loadScene(const std::string& path);

/// `image` is for cameras that do not give their own size. ERROR: naming file, camera and field.
Result<std::vector<Camera>> readCameras(const std::string& path, protocol::ImageSize image = {});

}  // namespace culld
