#include "server/scene.h"

#include <algorithm>

#include "culling/planner/scene_profile.h"
#include "server/scene_names.h"

namespace culld::server {

SceneVersion::SceneVersion(Methods methods, SnapshotPtr snapshot, std::uint64_t epoch)
    : methods_(methods),
      snapshot_(std::move(snapshot)),
      epoch_(epoch),
      profile_(profileScene(*snapshot_)),
      slots_(methods.size()) {}

SceneVersion::SceneVersion(const SceneVersion& before, SnapshotPtr next)
    : methods_(before.methods_),
      snapshot_(std::move(next)),
      epoch_(before.epoch_),
      profile_(before.profile_),  // a hint for choosing methods; edits hardly move it
      slots_(before.slots_.size()),
      pieces_(before.pieces_) {}

Result<const Method*> SceneVersion::method(std::string_view name) const {
  const bool any = name.empty() || name == "auto";
  const Method* method = findMethod(methods_, any ? "auto" : name);
  if (method == nullptr && any && !methods_.empty()) method = methods_.front();
  if (method != nullptr) {
    if (auto fits = method->accepts(profile_); !fits) return fits.error();
    return method;
  }
  return Error{ErrorCode::kNotFound, "method \"" + std::string(name) + "\" is not known"};
}

SceneVersion::Slot& SceneVersion::slotOf(const Method& method) const {
  const auto at = std::find(methods_.begin(), methods_.end(), &method);
  return slots_[static_cast<std::size_t>(at - methods_.begin())];
}

Result<std::shared_ptr<const Culler>> SceneVersion::culler(const Method& method) const {
  Slot& slot = slotOf(method);
  const std::lock_guard lock(slot.mutex);
  if (!slot.culler) {
    auto prepared = method.prepare(snapshot_);
    slot.culler = prepared ? Prepared(std::shared_ptr<const Culler>(std::move(prepared).value()))
                           : Prepared(prepared.error());
  }
  return *slot.culler;
}

std::shared_ptr<const Culler> SceneVersion::readyCuller(const Method& method) const {
  Slot& slot = slotOf(method);
  const std::unique_lock lock(slot.mutex, std::try_to_lock);
  return lock && slot.culler && slot.culler->ok() ? slot.culler->value() : nullptr;
}

std::shared_ptr<const PairsCuller> SceneVersion::pairs() const {
  const std::lock_guard lock(pairs_mutex_);
  if (pairs_) return pairs_;
  const std::lock_guard pieces_lock(pieces_->mutex);
  if (!pieces_->pieces) pieces_->pieces = piecesOfMeshes(*snapshot_);
  pairs_ = std::make_shared<const PairsCuller>(*snapshot_, pieces_->pieces);
  return pairs_;
}

SceneVersionPtr SceneVersion::edited(SnapshotPtr next, std::span<const ObjectId> changed) const {
  std::shared_ptr<SceneVersion> version(new SceneVersion(*this, std::move(next)));
  for (std::size_t i = 0; i < slots_.size(); ++i) {
    const std::lock_guard lock(slots_[i].mutex);
    if (!slots_[i].culler || !slots_[i].culler->ok()) continue;
    auto refitted = slots_[i].culler->value()->edited(version->snapshot_, changed);
    // A culler that cannot follow the edit is prepared anew when it is next asked for.
    if (refitted) {
      version->slots_[i].culler = std::shared_ptr<const Culler>(std::move(refitted).value());
    }
  }
  return version;
}

Scene::Scene(std::string name, Methods methods, SnapshotPtr snapshot,
             std::unique_ptr<EditStore> store)
    : name_(std::move(name)),
      methods_(methods),
      store_(std::move(store)),
      current_(std::make_shared<SceneVersion>(methods, std::move(snapshot), 1)) {}

SceneVersionPtr Scene::current() const {
  const std::lock_guard lock(current_mutex_);
  return current_;
}

void Scene::publish(SceneVersionPtr next) {
  const std::lock_guard lock(current_mutex_);
  current_.swap(next);  // the old one dies outside, in `next`'s owner
}

namespace {

/// One request on top of `scene`, which becomes what it made.
Result<EditOutcome> applyRequest(const std::string& name, const EditRequest& request,
                                 SnapshotPtr& scene, std::vector<ObjectId>& changed) {
  const std::uint64_t version = scene->version();
  if (request.expected_version != 0 && request.expected_version != version) {
    return Error{ErrorCode::kUnavailable, "edit: scene \"" + std::string(publicName(name)) +
                                              "\" is at version " + std::to_string(version) +
                                              ", not " + std::to_string(request.expected_version)};
  }
  auto edited = applyEdits(scene, request.edits);
  if (!edited) return edited.error();
  const EditedScene& next = edited.value();
  EditOutcome outcome;
  outcome.version = next.snapshot->version();
  for (auto id = scene->objectCount(); id < next.snapshot->objectCount(); ++id) {
    outcome.added.push_back(static_cast<ObjectId>(id));
  }
  changed.insert(changed.end(), next.changed.begin(), next.changed.end());
  scene = next.snapshot;
  return outcome;
}

}  // namespace

std::vector<Result<EditOutcome>> Scene::edit(std::span<const EditRequest> requests) {
  const std::lock_guard lock(writers_);
  const SceneVersionPtr before = current();
  SnapshotPtr next = before->snapshot();
  std::vector<Result<EditOutcome>> outcomes;
  std::vector<ObjectId> changed;
  std::vector<Edit> applied;
  for (const EditRequest& request : requests) {
    outcomes.push_back(applyRequest(name_, request, next, changed));
    if (!outcomes.back()) continue;
    applied.insert(applied.end(), request.edits.begin(), request.edits.end());
  }
  if (next == before->snapshot()) return outcomes;
  std::sort(changed.begin(), changed.end());
  changed.erase(std::unique(changed.begin(), changed.end()), changed.end());
  // All that may fail comes before the commit: what is on disk must become what is served.
  SceneVersionPtr version = before->edited(next, changed);
  if (store_) {
    const auto kept = store_->commit(*before->snapshot(), *next, applied);
    if (!kept) {
      // Of all: some may have failed only for what came before them, which never was.
      for (auto& outcome : outcomes) outcome = Error{kept.error().code, kept.error().message};
      return outcomes;
    }
  }
  publish(std::move(version));
  return outcomes;
}

void Scene::tidy() {
  const std::lock_guard lock(writers_);
  if (store_) store_->tidy();
}

void Scene::replace(SnapshotPtr snapshot, std::unique_ptr<EditStore> store) {
  auto next = std::make_shared<SceneVersion>(methods_, std::move(snapshot), current()->epoch() + 1);
  const std::lock_guard lock(writers_);
  if (store_) store_->discard();
  store_ = std::move(store);
  publish(std::move(next));
}

void Scene::restore(const EditedScene& edited) {
  const std::lock_guard lock(writers_);
  publish(current()->edited(edited.snapshot, edited.changed));
}

void Scene::retire() {
  const std::lock_guard lock(writers_);
  if (store_) store_->discard();
}

void Scene::haltEdits(const std::string& reason) {
  const std::lock_guard lock(writers_);
  if (store_) store_->halt(reason);
}

}  // namespace culld::server
