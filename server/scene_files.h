// Scenes on disk: DIR/scenes/NAME~SERIAL.scene holds the uploaded bytes and a seal. An upload
// becomes a scene by fsync, rename and fsync of the folder; the highest serial of a name counts. So
// a power cut leaves the old scene or the new one, and what failed can be undone.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "culling/core/result.h"
#include "server/checksum.h"
#include "server/disk.h"

namespace culld::server {

/// An upload under way; its file goes away with it unless it is committed.
class Upload {
 public:
  Upload(FileDescriptor file, std::filesystem::path path);
  Upload(Upload&& other) noexcept;
  Upload& operator=(Upload&&) = delete;
  ~Upload();

  /// ERROR: kIo, e.g. "upload: cannot write: No space left on device".
  Result<void> append(std::span<const std::byte> bytes);
  std::uint64_t size() const noexcept { return size_; }
  const std::filesystem::path& path() const noexcept { return path_; }

 private:
  friend class SceneFiles;
  FileDescriptor file_;
  std::filesystem::path path_;  ///< empty once committed
  std::uint64_t size_ = 0;
  Checksum checksum_;
};

/// THREADS: any, but one change at a time.
class SceneFiles {
 public:
  /// Makes what is missing, removes half uploads, keeps other processes out. An empty `folder`
  /// stands for a temporary one that is removed at the end.
  /// ERROR: kIo; kUnavailable: another process holds the folder.
  static Result<std::unique_ptr<SceneFiles>> open(const std::filesystem::path& folder);
  ~SceneFiles();
  /// Removes the temporary folder, if this is one, before the end of life.
  void removeTemporary() noexcept;
  bool temporary() const noexcept { return temporary_; }
  const std::filesystem::path& folder() const noexcept { return folder_; }
  SerialSource& serials() noexcept { return serials_; }

  /// The scenes by name with their serials, and what else lies in the folder and is no scene.
  struct Stored {
    std::map<std::string, std::uint64_t> scenes;
    std::vector<std::string> foreign;
  };
  /// ERROR: kIo: the folder cannot be read.
  Result<Stored> stored() const;
  std::filesystem::path pathOf(const std::string& name, std::uint64_t serial) const;

  Result<Upload> beginUpload();
  /// The serial of the scene. GUARANTEES: after success the scene is on disk, also after a power
  /// cut; after a failure nothing has changed, or no further change is taken: see halted().
  /// ERROR: kIo.
  Result<std::uint64_t> commit(Upload& upload, const std::string& name);
  /// Files of `name` that `serial` has replaced: left over when a process ended in between.
  void removeOlder(const std::string& name, std::uint64_t serial);
  /// GUARANTEES: as commit. A scene without a file is fine.
  Result<void> erase(const std::string& name);

  /// Set when a change failed and could not be undone: what is on disk is not known any more, and
  /// only a new start, which reads it, can tell.
  bool halted() const noexcept { return halted_; }

 private:
  SceneFiles(std::filesystem::path folder, bool temporary);
  Result<void> prepare();
  Result<std::vector<std::uint64_t>> serialsOf(const std::string& name) const;
  Result<void> refuseIfHalted() const;

  std::filesystem::path folder_;
  bool temporary_;
  FileDescriptor lock_;
  SerialSource serials_{1};
  std::atomic<bool> halted_{false};
};

}  // namespace culld::server
