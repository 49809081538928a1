// The edits of a scene across restarts. Each scene has a folder DIR/edits/NAME~KEY~SERIAL of its
// own, so that damage to one leaves the others alone. KEY says of which scene file the edits are:
// edits of another one under the same name are stale and are swept away, whenever the process
// ended.
#pragma once
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "culling/scene/edit.h"
#include "server/disk.h"
#include "server/edit_database.h"

namespace culld::server {

/// Edits of an uploaded scene belong to that upload; those of a scene file given at start, to its
/// content.
std::string keyOfUpload(std::uint64_t serial);
std::string keyOfContent(std::uint64_t content_hash);

/// THREADS: one at a time.
class EditStore {
 public:
  EditStore(std::filesystem::path folder, std::string name, std::string key, SerialSource& serials);
  ~EditStore();

  /// The scene as edits left it, or nothing if it has none. REQUIRES: `base` is the scene as
  /// loaded. ERROR: naming the folder and what is wrong: damaged, of another version, not of this
  /// scene; nothing was changed on disk.
  Result<std::optional<EditedScene>> load(const SnapshotPtr& base);

  /// Keeps `edits`, which made `after` of `before`. GUARANTEES: after success they are on disk;
  /// after a failure they are not, unless the disk refuses the repair too, and nothing else is
  /// lost. ERROR: kIo.
  Result<void> commit(const SceneSnapshot& before, const SceneSnapshot& after,
                      std::span<const Edit> edits);
  /// What can wait until a commit was acknowledged: keeps the log short.
  void tidy();
  /// Removes all of it: the scene is gone, or another one is under its name.
  void discard();
  /// No more commits, with this reason.
  void halt(std::string reason) { halted_ = std::move(reason); }

 private:
  struct Touched {
    std::optional<ObjectId> like;
    bool moved = false;
    std::uint64_t checksum = 0;
  };
  using TouchedObjects = std::map<ObjectId, Touched>;

  std::string owner() const { return name_ + " " + key_; }
  Error named(Error error) const;
  Result<void> make(const SceneSnapshot& scene);
  Result<void> fill(const std::filesystem::path& folder, const SceneSnapshot& scene) const;
  Result<void> openMade();
  Result<void> writeMark(const EditTotals& totals);
  TouchedObjects touchedBy(const SceneSnapshot& before, std::span<const Edit> edits) const;

  const std::filesystem::path folder_;  ///< of all stores
  const std::string name_, key_;
  SerialSource& serials_;
  std::filesystem::path path_;  ///< empty: no edit was made yet
  std::optional<EditDatabase> database_;
  FileDescriptor mark_;
  std::size_t next_mark_ = 0;
  TouchedObjects touched_;
  EditTotals totals_;
  std::string halted_;
};

/// The folder of all edit stores.
class EditFolder {
 public:
  /// Makes it, removes what a process that is gone left half done. ERROR: kIo.
  static Result<std::unique_ptr<EditFolder>> open(const std::filesystem::path& folder,
                                                  SerialSource& serials);

  std::unique_ptr<EditStore> storeOf(const std::string& name, const std::string& key);
  /// Removes stores of uploads that `scenes` (name and serial) does not have any more. What is no
  /// edit store is left alone, and named in a line each.
  std::vector<std::string> sweep(const std::map<std::string, std::uint64_t>& scenes);
  /// Removes what `name` has, but for `keep`: of uploads, of files given at start, or of both.
  enum class Which { kOfFiles, kAll };
  void removeStores(const std::string& name, Which which, const std::string& keep = {});

 private:
  EditFolder(std::filesystem::path folder, SerialSource& serials)
      : folder_(std::move(folder)), serials_(serials) {}

  const std::filesystem::path folder_;
  SerialSource& serials_;
};

}  // namespace culld::server
