#include "server/scene.h"

#include <algorithm>

#include "culling/planner/scene_profile.h"

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
      slots_(before.slots_.size()) {}

Result<const Method*> SceneVersion::method(std::string_view name) const {
  const bool any = name.empty() || name == "auto";
  const auto named = std::find_if(methods_.begin(), methods_.end(), [&](const Method* method) {
    return method->info().name == (any ? "auto" : name);
  });
  const Method* method = named != methods_.end()    ? *named
                         : any && !methods_.empty() ? methods_.front()
                                                    : nullptr;
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

Scene::Scene(std::string name, Methods methods, SnapshotPtr snapshot)
    : name_(std::move(name)),
      methods_(methods),
      current_(std::make_shared<SceneVersion>(methods, std::move(snapshot), 1)) {}

SceneVersionPtr Scene::current() const {
  const std::lock_guard lock(current_mutex_);
  return current_;
}

void Scene::publish(SceneVersionPtr next) {
  const std::lock_guard lock(current_mutex_);
  current_.swap(next);  // the old one dies outside, in `next`'s owner
}

Result<EditOutcome> Scene::edit(std::span<const Edit> edits, std::uint64_t expected_version) {
  const std::lock_guard lock(writers_);
  const SceneVersionPtr before = current();
  const std::uint64_t version = before->snapshot()->version();
  if (expected_version != 0 && expected_version != version) {
    return Error{ErrorCode::kUnavailable, "edit: scene \"" + name_ + "\" is at version " +
                                              std::to_string(version) + ", not " +
                                              std::to_string(expected_version)};
  }
  auto edited = applyEdits(before->snapshot(), edits);
  if (!edited) return edited.error();
  EditOutcome outcome;
  const auto& next = edited.value();
  outcome.version = next.snapshot->version();
  for (auto id = before->snapshot()->objectCount(); id < next.snapshot->objectCount(); ++id) {
    outcome.added.push_back(static_cast<ObjectId>(id));
  }
  publish(before->edited(next.snapshot, next.changed));
  return outcome;
}

void Scene::replace(SnapshotPtr snapshot) {
  const std::lock_guard lock(writers_);
  publish(std::make_shared<SceneVersion>(methods_, std::move(snapshot), current()->epoch() + 1));
}

}  // namespace culld::server
