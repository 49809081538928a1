#include "server/scene_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace culld::server {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".scene";

Error ioError(const std::string& what) {
  return {ErrorCode::kIo, what + ": " + std::strerror(errno)};
}

Result<void> syncFolder(const fs::path& folder) {
  const FileDescriptor fd(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (fd.get() < 0) return ioError(folder.string() + ": cannot open");
  if (::fsync(fd.get()) != 0) return ioError(folder.string() + ": cannot sync");
  return Done{};
}

Result<void> makeFolder(const fs::path& folder) {
  std::error_code failure;
  fs::create_directories(folder, failure);
  if (failure) {
    return Error{ErrorCode::kIo, folder.string() + ": cannot make: " + failure.message()};
  }
  return Done{};
}

}  // namespace

bool validSceneName(std::string_view name) noexcept {
  if (name.empty() || name.size() > 64 || name.front() == '.') return false;
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '.' ||
           c == '_' || c == '-';
  });
}

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

Upload::Upload(FileDescriptor file, fs::path path)
    : file_(std::move(file)), path_(std::move(path)) {}

Upload::Upload(Upload&& other) noexcept
    : file_(std::move(other.file_)), path_(std::exchange(other.path_, {})), size_(other.size_) {}

Upload::~Upload() {
  if (!path_.empty()) ::unlink(path_.c_str());
}

Result<void> Upload::append(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(file_.get(), bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return ioError("upload: cannot write");
    bytes = bytes.subspan(static_cast<std::size_t>(n));
    size_ += static_cast<std::uint64_t>(n);
  }
  return Done{};
}

SceneFiles::SceneFiles(fs::path folder, bool temporary)
    : folder_(std::move(folder)), temporary_(temporary) {}

SceneFiles::~SceneFiles() { removeTemporary(); }

void SceneFiles::removeTemporary() noexcept {
  std::error_code ignored;  // a temporary folder that stays harms nobody
  if (temporary_) fs::remove_all(folder_, ignored);
}

Result<std::unique_ptr<SceneFiles>> SceneFiles::open(const fs::path& folder) {
  std::string path = folder.string();
  if (folder.empty()) {
    path = (fs::temp_directory_path() / "culld-XXXXXX").string();
    if (::mkdtemp(path.data()) == nullptr) return ioError(path + ": cannot make");
  }
  std::unique_ptr<SceneFiles> files(new SceneFiles(path, folder.empty()));
  if (auto ready = files->prepare(); !ready) return ready.error();
  return files;
}

Result<void> SceneFiles::prepare() {
  if (auto made = makeFolder(folder_ / "scenes"); !made) return made;
  const fs::path lock = folder_ / "lock";
  lock_ = FileDescriptor(::open(lock.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
  if (lock_.get() < 0) return ioError(lock.string() + ": cannot open");
  if (::flock(lock_.get(), LOCK_EX | LOCK_NB) != 0) {
    return Error{ErrorCode::kUnavailable, folder_.string() + ": another culld uses this folder"};
  }
  std::error_code failure;
  fs::remove_all(folder_ / "uploads", failure);  // half uploads of a process that is gone
  return makeFolder(folder_ / "uploads");
}

std::vector<std::string> SceneFiles::names() const {
  std::vector<std::string> names;
  std::error_code failure;
  for (const auto& entry : fs::directory_iterator(folder_ / "scenes", failure)) {
    std::string name = entry.path().filename().string();
    if (!name.ends_with(kSuffix)) continue;
    name.resize(name.size() - kSuffix.size());
    if (validSceneName(name)) names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end());
  return names;
}

fs::path SceneFiles::pathOf(const std::string& name) const {
  return folder_ / "scenes" / (name + std::string(kSuffix));
}

Result<Upload> SceneFiles::beginUpload() {
  std::string path = (folder_ / "uploads" / "XXXXXX").string();
  FileDescriptor file(::mkostemp(path.data(), O_CLOEXEC));
  if (file.get() < 0) return ioError("upload: cannot make a file");
  return Upload(std::move(file), path);
}

Result<void> SceneFiles::commit(Upload& upload, const std::string& name) {
  if (::fsync(upload.file_.get()) != 0) return ioError("upload: cannot sync");
  if (::rename(upload.path_.c_str(), pathOf(name).c_str()) != 0) {
    return ioError("upload: cannot rename");
  }
  upload.path_.clear();
  return syncFolder(folder_ / "scenes");
}

Result<void> SceneFiles::erase(const std::string& name) {
  if (::unlink(pathOf(name).c_str()) != 0) {
    if (errno == ENOENT) return Done{};
    return ioError("scene \"" + name + "\": cannot remove");
  }
  return syncFolder(folder_ / "scenes");
}

}  // namespace culld::server
