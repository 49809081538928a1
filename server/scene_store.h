// The scenes of a server by name: loaded from its folder, from files named at start, from uploads.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <vector>

#include "culling/scene/gltf_loader.h"
#include "server/scene.h"
#include "server/scene_files.h"

namespace culld::server {

struct SceneEntry {
  std::shared_ptr<Scene> scene;
  std::uint64_t file_bytes = 0;
};

/// THREADS: any, unless said otherwise.
class SceneStore {
 public:
  SceneStore(std::unique_ptr<SceneFiles> files, Methods methods, std::size_t max_scenes,
             LoadOptions load);

  /// Loads every scene of the folder. Returns one line for each that could not be read; those are
  /// not served. THREADS: call once, before uploads.
  std::vector<std::string> loadAll();
  /// A scene from a file that stays where it is.
  Result<void> addFile(const std::string& name, const std::string& path);

  Result<Upload> beginUpload() { return files_->beginUpload(); }
  /// Loads the upload, then keeps it, then serves it; true if the name is new.
  /// GUARANTEES: after success the scene survives kill -9 and a power cut.
  /// ERROR: the loader's; kUnavailable: too many scenes; kIo.
  Result<bool> finishUpload(const std::string& name, Upload upload);
  /// The scene that was removed. ERROR: kNotFound, kIo.
  Result<std::shared_ptr<Scene>> remove(const std::string& name);

  /// See SceneFiles.
  void removeTemporaryFiles() { files_->removeTemporary(); }

  std::shared_ptr<Scene> find(const std::string& name) const;
  std::map<std::string, SceneEntry> list() const;
  std::set<std::string> names() const;

 private:
  Result<SnapshotPtr> load(const std::filesystem::path& path, const std::string& name) const;
  bool serve(const std::string& name, SnapshotPtr snapshot, std::uint64_t file_bytes);

  const std::unique_ptr<SceneFiles> files_;
  const Methods methods_;
  const std::size_t max_scenes_;
  const LoadOptions load_options_;
  std::mutex writers_;        ///< one change of files and names at a time
  mutable std::mutex mutex_;  ///< guards scenes_
  std::map<std::string, SceneEntry> scenes_;
};

}  // namespace culld::server
