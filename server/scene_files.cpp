#include "server/scene_files.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <optional>
#include <utility>

#include "server/scene_names.h"
#include "server/scene_seal.h"

namespace culld::server {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSuffix = ".scene";

struct StoredName {
  std::string name;
  std::uint64_t serial = 0;
};

/// "NAME~0123456789abcdef.scene"
std::optional<StoredName> storedName(std::string_view file) {
  if (!file.ends_with(kSuffix)) return std::nullopt;
  file.remove_suffix(kSuffix.size());
  const auto tilde = file.find('~');
  if (tilde == std::string_view::npos) return std::nullopt;
  const auto serial = fromHex16(file.substr(tilde + 1));
  if (!serial || !validOwnedName(file.substr(0, tilde))) return std::nullopt;
  return StoredName{std::string(file.substr(0, tilde)), *serial};
}

}  // namespace

Upload::Upload(FileDescriptor file, fs::path path)
    : file_(std::move(file)), path_(std::move(path)) {}

Upload::Upload(Upload&& other) noexcept
    : file_(std::move(other.file_)),
      path_(std::exchange(other.path_, {})),
      size_(other.size_),
      checksum_(std::move(other.checksum_)) {}

Upload::~Upload() {
  if (!path_.empty()) ::unlink(path_.c_str());
}

Result<void> Upload::append(std::span<const std::byte> bytes) {
  if (auto written = writeAll(file_, bytes, "upload"); !written) return written;
  checksum_.add(bytes);
  size_ += bytes.size();
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
  if (auto made = makeFolder(folder_ / "uploads"); !made) return made;
  const auto scenes = stored();
  if (!scenes) return scenes.error();
  for (const auto& [name, serial] : scenes.value().scenes) skipSerial(serials_, serial);
  return Done{};
}

Result<SceneFiles::Stored> SceneFiles::stored() const {
  Stored stored;
  std::error_code failure;
  fs::directory_iterator entry(folder_ / "scenes", failure);
  for (; !failure && entry != fs::directory_iterator(); entry.increment(failure)) {
    const std::string file = entry->path().filename().string();
    if (const auto scene = storedName(file)) {
      std::uint64_t& serial = stored.scenes[scene->name];
      serial = std::max(serial, scene->serial);
    } else {
      stored.foreign.push_back(file);
    }
  }
  if (failure) {
    return Error{ErrorCode::kIo,
                 (folder_ / "scenes").string() + ": cannot read: " + failure.message()};
  }
  std::sort(stored.foreign.begin(), stored.foreign.end());
  return stored;
}

fs::path SceneFiles::pathOf(const std::string& name, std::uint64_t serial) const {
  return folder_ / "scenes" / (name + "~" + hex16(serial) + std::string(kSuffix));
}

Result<std::vector<std::uint64_t>> SceneFiles::serialsOf(const std::string& name) const {
  std::vector<std::uint64_t> serials;
  std::error_code failure;
  fs::directory_iterator entry(folder_ / "scenes", failure);
  for (; !failure && entry != fs::directory_iterator(); entry.increment(failure)) {
    const auto scene = storedName(entry->path().filename().string());
    if (scene && scene->name == name) serials.push_back(scene->serial);
  }
  if (failure) {
    return Error{ErrorCode::kIo,
                 (folder_ / "scenes").string() + ": cannot read: " + failure.message()};
  }
  std::sort(serials.begin(), serials.end());
  return serials;
}

Result<Upload> SceneFiles::beginUpload() {
  std::string path = (folder_ / "uploads" / "XXXXXX").string();
  FileDescriptor file(::mkostemp(path.data(), O_CLOEXEC));
  if (file.get() < 0) return ioError("upload: cannot make a file");
  return Upload(std::move(file), path);
}

Result<void> SceneFiles::refuseIfHalted() const {
  if (!halted_) return Done{};
  return Error{ErrorCode::kIo, folder_.string() +
                                   ": an earlier change failed and could not be undone; no more "
                                   "are made before a new start"};
}

Result<std::uint64_t> SceneFiles::commit(Upload& upload, const std::string& name) {
  if (auto fine = refuseIfHalted(); !fine) return fine.error();
  const Seal seal = makeSeal(upload.size_, upload.checksum_.digest());
  if (auto sealed = writeAll(upload.file_, seal, "upload"); !sealed) return sealed.error();
  if (::fsync(upload.file_.get()) != 0) return ioError("upload: cannot sync");
  const std::uint64_t serial = serials_++;
  MoveOutcome move = moveDurably(upload.path_, pathOf(name, serial), folder_ / "scenes");
  if (!move.moved) {
    halted_ = !move.undone;
    return Error{move.moved.error().code, "upload: " + move.moved.error().message};
  }
  upload.path_.clear();
  removeOlder(name, serial);
  return serial;
}

void SceneFiles::removeOlder(const std::string& name, std::uint64_t serial) {
  const auto serials = serialsOf(name);
  if (!serials) return;  // they go at the next start, or with the name
  for (const std::uint64_t older : serials.value()) {
    if (older < serial) ::unlink(pathOf(name, older).c_str());
  }
}

Result<void> SceneFiles::erase(const std::string& name) {
  if (auto fine = refuseIfHalted(); !fine) return fine;
  const auto serials = serialsOf(name);
  if (!serials) return serials.error();
  // The newest goes last: were an older one left behind, it would come back.
  for (const std::uint64_t serial : serials.value()) {
    const fs::path gone = folder_ / "uploads" / ("gone~" + hex16(serial));
    MoveOutcome move = moveDurably(pathOf(name, serial), gone, folder_ / "scenes");
    if (!move.moved) {
      halted_ = !move.undone;
      return Error{move.moved.error().code,
                   "scene \"" + name + "\": cannot remove: " + move.moved.error().message};
    }
    ::unlink(gone.c_str());
  }
  return Done{};
}

}  // namespace culld::server
