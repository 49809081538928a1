#include "server/scene_store.h"

#include "server/scene_names.h"
#include "server/scene_seal.h"

namespace culld::server {

namespace fs = std::filesystem;

SceneStore::SceneStore(std::unique_ptr<SceneFiles> files, std::unique_ptr<EditFolder> edits,
                       Methods methods, std::size_t max_scenes, LoadOptions load)
    : files_(std::move(files)),
      edits_(std::move(edits)),
      methods_(methods),
      max_scenes_(max_scenes),
      load_options_(std::move(load)) {}

Result<SceneStore::Loaded> SceneStore::load(const std::string& name, std::uint64_t serial) const {
  const fs::path path = files_->pathOf(name, serial);
  const auto file = MappedFile::open(path);
  if (!file) return file.error();
  const auto content = openSealed(file.value().bytes());
  if (!content) {
    return Error{content.error().code, path.string() + ": " + content.error().message};
  }
  auto snapshot = loadGltfBytes(content.value(), name, load_options_);
  if (!snapshot) return snapshot.error();
  return Loaded{std::move(snapshot).value(), content.value().size()};
}

std::unique_ptr<EditStore> SceneStore::editsOf(const std::string& name, const std::string& key) {
  return edits_ == nullptr ? nullptr : edits_->storeOf(name, key);
}

Result<void> SceneStore::addEdited(const std::string& name, const Loaded& loaded,
                                   const std::string& key) {
  auto store = editsOf(name, key);
  std::optional<EditedScene> edited;
  if (store != nullptr) {
    auto found = store->load(loaded.snapshot);
    if (!found) return found.error();
    edited = std::move(found).value();
  }
  auto scene = std::make_shared<Scene>(name, methods_, loaded.snapshot, std::move(store));
  if (edited) scene->restore(*edited);
  const std::lock_guard lock(mutex_);
  scenes_.insert_or_assign(name, SceneEntry{std::move(scene), loaded.file_bytes});
  return Done{};
}

Result<void> SceneStore::loadStored(const std::string& name, std::uint64_t serial) {
  auto loaded = load(name, serial);
  if (!loaded) return loaded.error();
  if (auto added = addEdited(name, loaded.value(), keyOfUpload(serial)); !added) return added;
  files_->removeOlder(name, serial);
  return Done{};
}

std::string SceneStore::setAside(const std::string& name, const Error& error) {
  const std::lock_guard lock(mutex_);
  damaged_.insert(name);
  return "stored scene \"" + name + "\" is not served: " + error.message;
}

Result<std::vector<std::string>> SceneStore::loadAll(const std::set<std::string>& given) {
  std::vector<std::string> lines;
  const auto stored = files_->stored();
  if (!stored) return stored.error();
  for (const std::string& file : stored.value().foreign) {
    lines.push_back(file + ": not a stored scene of culld; left alone");
  }
  if (edits_ != nullptr) {
    for (std::string& line : edits_->sweep(stored.value().scenes)) lines.push_back(std::move(line));
  }
  for (const auto& [name, serial] : stored.value().scenes) {
    if (given.contains(name)) continue;
    if (auto loaded = loadStored(name, serial); !loaded) {
      lines.push_back(setAside(name, loaded.error()));
    }
  }
  return lines;
}

Result<std::optional<std::string>> SceneStore::addFile(const std::string& name,
                                                       const std::string& path) {
  if (!validSceneName(name)) {
    return invalidInput("scene name \"" + name + "\": not [A-Za-z0-9._-]{1,64}");
  }
  auto snapshot = loadGltfFile(path, load_options_);
  if (!snapshot) return snapshot.error();
  std::error_code failure;
  const auto bytes = fs::file_size(path, failure);
  const std::string key = keyOfContent(snapshot.value()->contentHash());
  if (edits_ != nullptr) edits_->removeStores(name, EditFolder::Which::kOfFiles, key);
  auto added = addEdited(name, {std::move(snapshot).value(), failure ? 0 : bytes}, key);
  return added ? std::nullopt : std::optional(setAside(name, added.error()));
}

Result<bool> SceneStore::finishUpload(const std::string& name, Upload upload) {
  const std::string shown(publicName(name));
  auto snapshot = [&]() -> Result<SnapshotPtr> {
    const auto file = MappedFile::open(upload.path());
    if (!file) return file.error();
    // From memory: what a stranger uploaded must not make the loader open other files.
    return loadGltfBytes(file.value().bytes(), shown, load_options_);
  }();
  if (!snapshot) return snapshot.error();
  const std::lock_guard lock(writers_);
  const std::shared_ptr<Scene> held = find(name);
  if (held == nullptr && list().size() >= max_scenes_) {
    // Not the upload's fault: with a scene less it is welcome.
    return Error{ErrorCode::kUnavailable, "scene \"" + shown +
                                              "\": " + std::to_string(max_scenes_) +
                                              " scenes are held, and no more are taken"};
  }
  const auto serial = files_->commit(upload, name);
  if (!serial) {
    if (files_->halted() && held != nullptr) held->haltEdits("an upload could not be undone");
    return Error{serial.error().code, "scene \"" + shown + "\": " + serial.error().message};
  }
  const std::string key = keyOfUpload(serial.value());
  auto store = editsOf(name, key);
  std::shared_ptr<Scene> served = held;
  if (held != nullptr) {
    held->replace(std::move(snapshot).value(), std::move(store));
  } else {
    served = std::make_shared<Scene>(name, methods_, std::move(snapshot).value(), std::move(store));
  }
  if (edits_ != nullptr) edits_->removeStores(name, EditFolder::Which::kAll, key);
  const std::lock_guard naming(mutex_);
  scenes_.insert_or_assign(name, SceneEntry{std::move(served), upload.size()});
  damaged_.erase(name);
  return held == nullptr;
}

Result<std::shared_ptr<Scene>> SceneStore::remove(const std::string& name) {
  const std::lock_guard writing(writers_);
  auto scene = find(name);
  if (!holds(name)) {
    return Error{ErrorCode::kNotFound,
                 "scene \"" + std::string(publicName(name)) + "\" is not known"};
  }
  if (auto erased = files_->erase(name); !erased) {
    if (files_->halted() && scene != nullptr) scene->haltEdits("a removal could not be undone");
    return erased.error();
  }
  if (scene != nullptr) scene->retire();
  if (edits_ != nullptr) edits_->removeStores(name, EditFolder::Which::kAll);
  const std::lock_guard lock(mutex_);
  scenes_.erase(name);
  damaged_.erase(name);
  return scene;
}

std::shared_ptr<Scene> SceneStore::find(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  const auto at = scenes_.find(name);
  return at == scenes_.end() ? nullptr : at->second.scene;
}

bool SceneStore::holds(const std::string& name) const {
  const std::lock_guard lock(mutex_);
  return scenes_.contains(name) || damaged_.contains(name);
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

std::set<std::string> SceneStore::damaged() const {
  const std::lock_guard lock(mutex_);
  return damaged_;
}

}  // namespace culld::server
