#include "culling/scene/edit.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "culling/scene/scene_hash.h"

namespace culld {

/// Applies edits one by one to a copy that nobody else sees yet.
class SceneEditor {
 public:
  explicit SceneEditor(const SceneSnapshot& base) : scene_(std::make_shared<SceneSnapshot>(base)) {}

  Result<void> apply(const Edit& edit) {
    return std::visit([this](const auto& e) { return on(e); }, edit);
  }

  EditedScene finish(std::uint64_t version) {
    std::sort(changed_.begin(), changed_.end());
    changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
    scene_->chunk_hashes_.resize(scene_->instances_.chunkCount());
    constexpr std::size_t kChunk = ChunkedArray<Instance>::kChunkSize;
    for (std::size_t i = 0; i < changed_.size(); ++i) {
      const std::size_t c = changed_[i] / kChunk;
      if (i > 0 && changed_[i - 1] / kChunk == c) continue;
      scene_->chunk_hashes_[c] = hashInstances(scene_->instances_.chunk(c));
    }
    scene_->content_hash_ = scene_->combinedHash();
    scene_->version_ = version;
    return {std::move(scene_), std::move(changed_)};
  }

 private:
  Result<void> on(const MoveObject& edit) {
    if (auto fine = checkObject("move", edit.object); !fine) return fine;
    if (auto fine = checkFinite("move", edit.object, edit.world_from_mesh); !fine) return fine;
    Instance& instance = change(edit.object);
    place(instance, scene_->mesh(instance.mesh), edit.world_from_mesh);
    return Done{};
  }
  Result<void> on(const HideObject& edit) { return setHidden("hide", edit.object, true); }
  Result<void> on(const ShowObject& edit) { return setHidden("show", edit.object, false); }
  Result<void> on(const RemoveObject& edit) {
    if (auto fine = checkObject("remove", edit.object); !fine) return fine;
    Instance& instance = change(edit.object);
    instance.removed = true;
    scene_->triangle_count_ -= scene_->mesh(instance.mesh).triangles.size();
    return Done{};
  }
  Result<void> on(const AddInstance& edit) {
    if (auto fine = checkObject("add", edit.like); !fine) return fine;
    if (auto fine = checkFinite("add like", edit.like, edit.world_from_mesh); !fine) return fine;
    if (scene_->objectCount() >= kMaxObjects) {
      return Error{ErrorCode::kLimit, "edit: add: the scene has no free object id"};
    }
    const Instance& like = scene_->instance(edit.like);
    const auto id = static_cast<ObjectId>(scene_->objectCount());
    Instance added;
    added.mesh = like.mesh;
    added.node = like.node;
    added.instance_number = id;
    place(added, scene_->mesh(like.mesh), edit.world_from_mesh);
    scene_->instances_.push_back(added);
    scene_->triangle_count_ += scene_->mesh(added.mesh).triangles.size();
    changed_.push_back(id);
    return Done{};
  }

  Result<void> setHidden(const char* what, ObjectId object, bool hidden) {
    if (auto fine = checkObject(what, object); !fine) return fine;
    change(object).hidden = hidden;
    return Done{};
  }

  Result<void> checkObject(const std::string& what, ObjectId object) const {
    const std::string place = "edit: " + what + " object " + std::to_string(object) + ": ";
    if (object >= scene_->objectCount()) {
      return invalidInput(place + "the scene has " + std::to_string(scene_->objectCount()) +
                          " objects");
    }
    if (scene_->instance(object).removed) return invalidInput(place + "it was removed");
    return Done{};
  }

  static Result<void> checkFinite(const std::string& what, ObjectId object,
                                  const std::array<double, 12>& rows) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (std::isfinite(rows[i])) continue;
      return invalidInput("edit: " + what + " object " + std::to_string(object) +
                          ": transform entry " + std::to_string(i) + " is not finite");
    }
    return Done{};
  }

  Instance& change(ObjectId object) {
    changed_.push_back(object);
    return scene_->instances_.mutableAt(object);
  }

  static constexpr std::size_t kMaxObjects = 0xFFFFFFFFU;

  std::shared_ptr<SceneSnapshot> scene_;
  std::vector<ObjectId> changed_;
};

Result<EditedScene> restoreEdits(const SnapshotPtr& scene, std::span<const Edit> edits,
                                 std::uint64_t version) {
  SceneEditor editor(*scene);
  for (const Edit& edit : edits) {
    if (auto applied = editor.apply(edit); !applied) return std::move(applied).error();
  }
  return editor.finish(version);
}

Result<EditedScene> applyEdits(const SnapshotPtr& scene, std::span<const Edit> edits) {
  return restoreEdits(scene, edits, scene->version() + 1);
}

}  // namespace culld
