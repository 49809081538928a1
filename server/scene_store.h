// The scenes of a server by name: loaded from its folder, from files named at start, from uploads.
// What survives a restart, and why: docs/durability.md.
#pragma once
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "culling/scene/gltf_loader.h"
#include "server/edit_store.h"
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
  /// `edits`: where they are kept; none: they live as long as the process.
  SceneStore(std::unique_ptr<SceneFiles> files, std::unique_ptr<EditFolder> edits, Methods methods,
             std::size_t max_scenes, LoadOptions load);

  /// Loads every scene of the folder but those in `given`, whose names addFile() serves, each with
  /// its edits. A scene whose file or edits are damaged is not served, and left as it is. Returns a
  /// line for each of these, and for each thing that is none of culld's.
  /// ERROR: kIo: the folder cannot be read. THREADS: call once, before uploads.
  Result<std::vector<std::string>> loadAll(const std::set<std::string>& given = {});
  /// A scene from a file that stays where it is, with the edits made to it when it had this
  /// content. Returns a line if these are damaged: it is not served then. ERROR: the loader's.
  Result<std::optional<std::string>> addFile(const std::string& name, const std::string& path);

  Result<Upload> beginUpload() { return files_->beginUpload(); }
  /// Loads the upload, then keeps it, then serves it; true if the name is new. The edits of a scene
  /// that it replaces are over.
  /// GUARANTEES: after success the scene survives kill -9 and a power cut.
  /// ERROR: the loader's; kUnavailable: too many scenes; kIo.
  Result<bool> finishUpload(const std::string& name, Upload upload);
  /// The scene that was removed, with its edits; null if it was damaged. ERROR: kNotFound, kIo.
  Result<std::shared_ptr<Scene>> remove(const std::string& name);

  /// See SceneFiles.
  void removeTemporaryFiles() { files_->removeTemporary(); }

  std::shared_ptr<Scene> find(const std::string& name) const;
  /// Whether the name is taken, by a scene that is served or by a damaged one.
  bool holds(const std::string& name) const;
  std::map<std::string, SceneEntry> list() const;
  std::set<std::string> names() const;
  /// Names that are not served because what is stored under them is damaged. An upload under such a
  /// name replaces it, a removal removes it; nothing else touches it.
  std::set<std::string> damaged() const;

 private:
  struct Loaded {
    SnapshotPtr snapshot;
    std::uint64_t file_bytes = 0;
  };
  Result<Loaded> load(const std::string& name, std::uint64_t serial) const;
  Result<void> loadStored(const std::string& name, std::uint64_t serial);
  std::unique_ptr<EditStore> editsOf(const std::string& name, const std::string& key);
  std::string setAside(const std::string& name, const Error& error);
  /// Adds a new scene as its edits left it. ERROR: of the store.
  Result<void> addEdited(const std::string& name, const Loaded& loaded, const std::string& key);

  const std::unique_ptr<SceneFiles> files_;
  const std::unique_ptr<EditFolder> edits_;
  const Methods methods_;
  const std::size_t max_scenes_;
  const LoadOptions load_options_;
  std::mutex writers_;        ///< one change of files and names at a time
  mutable std::mutex mutex_;  ///< guards what follows
  std::map<std::string, SceneEntry> scenes_;
  std::set<std::string> damaged_;
};

}  // namespace culld::server
