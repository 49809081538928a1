// One scene that the server holds: its current version, and the methods prepared for it.
// Readers take the current version and keep it as long as they like; writers make the next one.
#pragma once
#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "culling/culler.h"
#include "culling/pairs/pairs.h"
#include "culling/scene/edit.h"
#include "server/edit_store.h"

namespace culld::server {

/// What a server offers; in the daemon allMethods(), in tests their own.
using Methods = std::span<const Method* const>;

/// Immutable but for cullers, which are prepared when first asked for. THREADS: any.
class SceneVersion {
 public:
  SceneVersion(Methods methods, SnapshotPtr snapshot, std::uint64_t epoch);

  const SnapshotPtr& snapshot() const noexcept { return snapshot_; }
  /// Counts the scenes held under this name; ids of another epoch mean nothing in this one.
  std::uint64_t epoch() const noexcept { return epoch_; }

  /// "" means "auto", which in a table without it is the first method. ERROR: kNotFound;
  /// kUnsupported, the method's own words on why not for this scene.
  Result<const Method*> method(std::string_view name) const;
  /// Prepared once; others who ask meanwhile wait. REQUIRES: `method` came from method().
  Result<std::shared_ptr<const Culler>> culler(const Method& method) const;

  /// The same if it is there already; null else, and while it is being prepared. Does not wait.
  std::shared_ptr<const Culler> readyCuller(const Method& method) const;

  /// For questions about pairs. Prepared once; others who ask meanwhile wait.
  std::shared_ptr<const PairsCuller> pairs() const;

  /// The next version of the same epoch, with the prepared cullers refitted. Waits for a method
  /// that is just being prepared: it would start from nothing otherwise, at every edit.
  std::shared_ptr<const SceneVersion> edited(SnapshotPtr next,
                                             std::span<const ObjectId> changed) const;

 private:
  using Prepared = Result<std::shared_ptr<const Culler>>;
  struct Slot {
    std::mutex mutex;
    std::optional<Prepared> culler;
  };
  SceneVersion(const SceneVersion& before, SnapshotPtr next);
  Slot& slotOf(const Method& method) const;

  Methods methods_;
  SnapshotPtr snapshot_;
  std::uint64_t epoch_;
  SceneProfile profile_;
  mutable std::vector<Slot> slots_;  ///< one per method
  /// Made once for all versions: no edit changes meshes.
  struct SharedPieces {
    std::mutex mutex;
    std::shared_ptr<const MeshPieces> pieces;
  };
  std::shared_ptr<SharedPieces> pieces_ = std::make_shared<SharedPieces>();
  mutable std::mutex pairs_mutex_;
  mutable std::shared_ptr<const PairsCuller> pairs_;
};

using SceneVersionPtr = std::shared_ptr<const SceneVersion>;

struct EditOutcome {
  std::uint64_t version = 0;
  std::vector<ObjectId> added;
};

struct EditRequest {
  std::vector<Edit> edits;
  std::uint64_t expected_version = 0;  ///< 0: any
};

class Scene {
 public:
  /// `store`: where edits are kept; none: they live as long as the scene.
  Scene(std::string name, Methods methods, SnapshotPtr snapshot,
        std::unique_ptr<EditStore> store = nullptr);

  const std::string& name() const noexcept { return name_; }
  SceneVersionPtr current() const;

  /// Requests one after the other, each all or none, with one commit for all of them together.
  /// GUARANTEES: those that succeed are on disk, if there is a store, and then visible to every
  /// current() that comes after. ERROR: kUnavailable: at another version; kIo: of the store, and
  /// none of the requests was carried out; else as applyEdits.
  std::vector<Result<EditOutcome>> edit(std::span<const EditRequest> requests);
  /// What an edit leaves to be done once it was answered.
  void tidy();

  /// Another scene under the same name; the edits of this one are over.
  void replace(SnapshotPtr snapshot, std::unique_ptr<EditStore> store = nullptr);
  /// Goes on from `edited`, the current version as earlier edits left it.
  void restore(const EditedScene& edited);
  /// The scene is removed: its edits go, and no more are taken.
  void retire();
  /// No more edits, with this reason: they could not be kept.
  void haltEdits(const std::string& reason);

 private:
  void publish(SceneVersionPtr next);

  const std::string name_;
  const Methods methods_;
  std::mutex writers_;  ///< one at a time; guards store_
  std::unique_ptr<EditStore> store_;
  mutable std::mutex current_mutex_;  ///< held for a pointer's copy only
  SceneVersionPtr current_;
};

}  // namespace culld::server
