#include "server/disk.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <utility>

namespace culld::server {

namespace fs = std::filesystem;

FileDescriptor::FileDescriptor(FileDescriptor&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)) {}

FileDescriptor& FileDescriptor::operator=(FileDescriptor&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}

FileDescriptor::~FileDescriptor() {
  if (fd_ >= 0) ::close(fd_);
}

Result<MappedFile> MappedFile::open(const fs::path& path) {
  const FileDescriptor fd(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
  struct stat info {};
  if (fd.get() < 0 || ::fstat(fd.get(), &info) != 0) {
    return ioError(path.filename().string() + ": cannot read");
  }
  MappedFile file;
  file.size_ = static_cast<std::size_t>(info.st_size);
  if (file.size_ == 0) return file;
  void* data = ::mmap(nullptr, file.size_, PROT_READ, MAP_PRIVATE, fd.get(), 0);
  if (data == MAP_FAILED) {
    file.size_ = 0;
    return ioError(path.filename().string() + ": cannot map");
  }
  file.data_ = static_cast<const std::byte*>(data);
  return file;
}

MappedFile::MappedFile(MappedFile&& other) noexcept
    : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}

MappedFile& MappedFile::operator=(MappedFile&& other) noexcept {
  std::swap(data_, other.data_);
  std::swap(size_, other.size_);
  return *this;
}

MappedFile::~MappedFile() {
  if (data_ != nullptr) ::munmap(const_cast<std::byte*>(data_), size_);
}

Result<std::string> readSmallFile(const std::string& path, std::size_t most) {
  // A pipe is neither waited for nor taken for an empty file.
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat info {};
  if (file.get() < 0 || ::fstat(file.get(), &info) != 0) return ioError(path + ": cannot open");
  if (!S_ISREG(info.st_mode)) return Error{ErrorCode::kIo, path + ": is no regular file"};
  std::string text(most + 1, '\0');
  std::size_t got = 0;
  while (got < text.size()) {
    const ssize_t n = ::read(file.get(), text.data() + got, text.size() - got);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return ioError(path + ": cannot read");
    if (n == 0) break;
    got += static_cast<std::size_t>(n);
  }
  text.resize(got);
  if (got <= most) return text;
  return Error{ErrorCode::kLimit, path + ": larger than " + std::to_string(most) + " bytes"};
}

Error ioError(const std::string& what) {
  return {ErrorCode::kIo, what + ": " + std::strerror(errno)};
}

Result<void> writeAll(const FileDescriptor& file, std::span<const std::byte> bytes,
                      const std::string& what) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(file.get(), bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return ioError(what + ": cannot write");
    bytes = bytes.subspan(static_cast<std::size_t>(n));
  }
  return Done{};
}

Result<void> syncFolder(const fs::path& folder) {
  const FileDescriptor fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (fd.get() < 0) return ioError(folder.string() + ": cannot open");
  if (::fsync(fd.get()) != 0) return ioError(folder.string() + ": cannot sync");
  return Done{};
}

Result<void> makeFolder(const fs::path& folder) {
  std::error_code failure;
  if (fs::is_directory(folder, failure)) return Done{};
  const fs::path above = fs::absolute(folder, failure).parent_path();
  if (above != folder && !above.empty()) {
    if (auto made = makeFolder(above); !made) return made;
  }
  if (::mkdir(folder.c_str(), 0777) != 0 && errno != EEXIST) {
    return ioError(folder.string() + ": cannot make");
  }
  return syncFolder(above);
}

Result<void> renamePath(const fs::path& from, const fs::path& to) {
  if (::rename(from.c_str(), to.c_str()) == 0) return Done{};
  return ioError(to.filename().string() + ": cannot rename");
}

MoveOutcome moveDurably(const fs::path& from, const fs::path& to, const fs::path& folder) {
  if (auto renamed = renamePath(from, to); !renamed) return {std::move(renamed), true};
  auto synced = syncFolder(folder);
  if (synced) return {Done{}, true};
  // Whether the disk has the new name is not known. Undone and synced it has the old state again.
  const bool undone = renamePath(to, from).ok() && syncFolder(folder).ok();
  return {std::move(synced), undone};
}

void skipSerial(SerialSource& source, std::uint64_t serial) noexcept {
  std::uint64_t next = source.load();
  while (next <= serial && !source.compare_exchange_weak(next, serial + 1)) {
  }
}

std::string hex16(std::uint64_t value) {
  static constexpr char kDigits[] = "0123456789abcdef";
  std::string out(16, '0');
  for (std::size_t i = 16; i-- > 0; value >>= 4) out[i] = kDigits[value & 15U];
  return out;
}

std::optional<std::uint64_t> fromHex16(std::string_view text) noexcept {
  const auto digit = [](char c) { return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f'); };
  if (text.size() != 16 || !std::all_of(text.begin(), text.end(), digit)) return std::nullopt;
  std::uint64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value, 16);
  return value;
}

bool validSceneName(std::string_view name) noexcept {
  if (name.empty() || name.size() > 64 || name.front() == '.') return false;
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  });
}

}  // namespace culld::server
