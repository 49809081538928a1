// Scenes on disk: DIR/scenes/NAME.scene holds the uploaded bytes unchanged. An upload becomes a
// scene by fsync, rename and fsync of the folder, so that a power cut leaves the old one or the new
// one.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "culling/core/result.h"

namespace culld::server {

/// [A-Za-z0-9._-]{1,64}, not beginning with a dot.
bool validSceneName(std::string_view name) noexcept;

/// An open file descriptor, closed at the end of its life.
class FileDescriptor {
 public:
  explicit FileDescriptor(int fd = -1) noexcept : fd_(fd) {}
  FileDescriptor(FileDescriptor&& other) noexcept;
  FileDescriptor& operator=(FileDescriptor&& other) noexcept;
  ~FileDescriptor();
  int get() const noexcept { return fd_; }

 private:
  int fd_;
};

/// A whole file, read-only in memory. The pages come from the file as they are touched.
class MappedFile {
 public:
  static Result<MappedFile> open(const std::filesystem::path& path);
  MappedFile(MappedFile&& other) noexcept;
  MappedFile& operator=(MappedFile&& other) noexcept;
  ~MappedFile();
  std::span<const std::byte> bytes() const noexcept { return {data_, size_}; }

 private:
  MappedFile() = default;
  const std::byte* data_ = nullptr;
  std::size_t size_ = 0;
};

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
};

class SceneFiles {
 public:
  /// Makes what is missing, removes half uploads, keeps other processes out. An empty `folder`
  /// stands for a temporary one that is removed at the end.
  /// ERROR: kIo; kUnavailable: another process holds the folder.
  static Result<std::unique_ptr<SceneFiles>> open(const std::filesystem::path& folder);
  ~SceneFiles();
  /// Removes the temporary folder, if this is one, before the end of life.
  void removeTemporary() noexcept;

  /// Names of all scenes, ascending.
  std::vector<std::string> names() const;
  std::filesystem::path pathOf(const std::string& name) const;
  Result<Upload> beginUpload();
  /// GUARANTEES: after success the scene is on disk, also after a power cut. ERROR: kIo.
  Result<void> commit(Upload& upload, const std::string& name);
  /// GUARANTEES: as commit. A scene without a file is fine.
  Result<void> erase(const std::string& name);

 private:
  SceneFiles(std::filesystem::path folder, bool temporary);
  Result<void> prepare();

  std::filesystem::path folder_;
  bool temporary_;
  FileDescriptor lock_;
};

}  // namespace culld::server
