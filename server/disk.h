// What the stores on disk share: descriptors, mapped files, folders that are synced, and the names
// of things in them. Every step that can fail says so.
#pragma once
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "culling/core/result.h"

namespace culld::server {

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

/// A regular file, which others may have written, as text.
/// ERROR: kIo; kLimit: larger than `most` bytes; both name `path`.
Result<std::string> readSmallFile(const std::string& path, std::size_t most);

/// kIo with `what` and the words of errno.
Error ioError(const std::string& what);

/// All bytes or an error that begins with `what`.
Result<void> writeAll(const FileDescriptor& file, std::span<const std::byte> bytes,
                      const std::string& what);
/// GUARANTEES: after success the names in the folder are on disk.
Result<void> syncFolder(const std::filesystem::path& folder);
/// Makes it and what is missing above it, and syncs the folder above. Fine if it is there.
Result<void> makeFolder(const std::filesystem::path& folder);
Result<void> renamePath(const std::filesystem::path& from, const std::filesystem::path& to);

/// renamePath() within `folder` and syncFolder() of it; if the second fails, the first is undone.
struct MoveOutcome {
  Result<void> moved = Done{};
  bool undone = true;  ///< after a failure: all is as before, on disk too
};
MoveOutcome moveDurably(const std::filesystem::path& from, const std::filesystem::path& to,
                        const std::filesystem::path& folder);

/// Gives every stored thing a number of its own, so that a newer one under the same name is known
/// as such. THREADS: any.
using SerialSource = std::atomic<std::uint64_t>;
/// `source` is past `serial` from now on.
void skipSerial(SerialSource& source, std::uint64_t serial) noexcept;

/// Sixteen hexadecimal digits, and back. Nothing else is taken.
std::string hex16(std::uint64_t value);
std::optional<std::uint64_t> fromHex16(std::string_view text) noexcept;

/// [A-Za-z0-9._-]{1,64}, not beginning with a dot.
bool validSceneName(std::string_view name) noexcept;

}  // namespace culld::server
