#include "server/scene_store.h"

namespace culld::server {

namespace fs = std::filesystem;

SceneStore::SceneStore(std::unique_ptr<SceneFiles> files, Methods methods, std::size_t max_scenes,
                       LoadOptions load)
    : files_(std::move(files)),
      methods_(methods),
      max_scenes_(max_scenes),
      load_options_(std::move(load)) {}

Result<SnapshotPtr> SceneStore::load(const fs::path& path, const std::string& name) const {
  const auto file = MappedFile::open(path);
  if (!file) return file.error();
  // From memory: what a stranger uploaded must not make the loader open other files.
  return loadGltfBytes(file.value().bytes(), name, load_options_);
}

std::vector<std::string> SceneStore::loadAll() {
  std::vector<std::string> failures;
  for (const std::string& name : files_->names()) {
    auto snapshot = load(files_->pathOf(name), name);
    std::error_code failure;
    const auto bytes = fs::file_size(files_->pathOf(name), failure);
    if (snapshot) {
      serve(name, std::move(snapshot).value(), failure ? 0 : bytes);
    } else {
      failures.push_back("stored scene " + snapshot.error().message);
    }
  }
  return failures;
}

Result<void> SceneStore::addFile(const std::string& name, const std::string& path) {
  if (!validSceneName(name)) {
    return invalidInput("scene name \"" + name + "\": not [A-Za-z0-9._-]{1,64}");
  }
  auto snapshot = loadGltfFile(path, load_options_);
  if (!snapshot) return snapshot.error();
  std::error_code failure;
  const auto bytes = fs::file_size(path, failure);
  serve(name, std::move(snapshot).value(), failure ? 0 : bytes);
  return Done{};
}

Result<bool> SceneStore::finishUpload(const std::string& name, Upload upload) {
  auto snapshot = load(upload.path(), name);
  if (!snapshot) return snapshot.error();
  const std::lock_guard lock(writers_);
  if (find(name) == nullptr && list().size() >= max_scenes_) {
    // Not the upload's fault: with a scene less it is welcome.
    return Error{ErrorCode::kUnavailable, "scene \"" + name + "\": " + std::to_string(max_scenes_) +
                                              " scenes are held, and no more are taken"};
  }
  if (auto kept = files_->commit(upload, name); !kept) {
    return Error{kept.error().code, "scene \"" + name + "\": " + kept.error().message};
  }
  return serve(name, std::move(snapshot).value(), upload.size());
}

bool SceneStore::serve(const std::string& name, SnapshotPtr snapshot, std::uint64_t file_bytes) {
  std::shared_ptr<Scene> held = find(name);
  const bool fresh = held == nullptr;
  if (fresh) {
    held = std::make_shared<Scene>(name, methods_, std::move(snapshot));
  } else {
    held->replace(std::move(snapshot));
  }
  const std::lock_guard lock(mutex_);
  scenes_.insert_or_assign(name, SceneEntry{held, file_bytes});
  return fresh;
}

Result<std::shared_ptr<Scene>> SceneStore::remove(const std::string& name) {
  const std::lock_guard writing(writers_);
  auto scene = find(name);
  if (scene == nullptr) return Error{ErrorCode::kNotFound, "scene \"" + name + "\" is not known"};
  if (auto erased = files_->erase(name); !erased) return erased.error();
  const std::lock_guard lock(mutex_);
  scenes_.erase(name);
  return scene;
}

std::shared_ptr<Scene> SceneStore::find(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto at = scenes_.find(name);
  return at == scenes_.end() ? nullptr : at->second.scene;
}

std::map<std::string, SceneEntry> SceneStore::list() const {
  const std::lock_guard lock(mutex_);
  return scenes_;
}

std::set<std::string> SceneStore::names() const {
  const std::lock_guard lock(mutex_);
  std::set<std::string> names;
  for (const auto& [name, entry] : scenes_) names.insert(name);
  return names;
}

}  // namespace culld::server
