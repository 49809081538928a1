// A library to preload: makes the N-th call that changes or syncs something below a folder fail, as
// a disk does that is full or broken, and counts what was changed and not yet synced.
// CULLD_FAULTS_FOLDER: the folder; CULLD_FAULTS_FILE: a DiskFaults to obey.
#include "tests/durability/disk_faults.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <set>
#include <string>

namespace {

using culld::testing::DiskFaults;

struct State {
  std::string folder;
  DiskFaults* faults = nullptr;
  std::mutex mutex;
  std::set<std::string> unsynced;  // paths
};

/// Made at the first call, never destroyed: calls come after the end of static objects too.
State& state() {
  static State& made = *[] {
    auto* fresh = new State;
    const char* folder = std::getenv("CULLD_FAULTS_FOLDER");
    const char* file = std::getenv("CULLD_FAULTS_FILE");
    if (folder == nullptr || file == nullptr) return fresh;
    const int fd = ::open(file, O_RDWR | O_CLOEXEC);
    void* shared = ::mmap(nullptr, sizeof(DiskFaults), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
    ::close(fd);
    if (shared == MAP_FAILED) return fresh;
    fresh->folder = std::string(folder) + "/";
    fresh->faults = static_cast<DiskFaults*>(shared);
    return fresh;
  }();
  return made;
}

template <typename Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

std::string pathOf(int fd) {
  char path[4096];
  const std::string link = "/proc/self/fd/" + std::to_string(fd);
  const ssize_t size = ::readlink(link.c_str(), path, sizeof path);
  return size <= 0 ? std::string() : std::string(path, static_cast<std::size_t>(size));
}

bool ours(const std::string& path) {
  return state().faults != nullptr && (path + "/").starts_with(state().folder);
}

/// Counts a call; true if it has to fail, with errno set.
bool fails(const std::string& path) {
  if (!ours(path)) return false;
  DiskFaults& faults = *state().faults;
  const std::uint64_t call = ++faults.calls;
  const std::uint64_t at = faults.fail_at;
  if (at == 0 || call < at || (call > at && faults.lasting == 0)) return false;
  ++faults.failed;
  errno = static_cast<int>(faults.error.load());
  return true;
}

bool needsNoSync(const std::string& path) {
  return path.ends_with("/mark") || path.ends_with("/uploads") ||
         path.find("/~tmp~") != std::string::npos;
}

void changed(const std::string& path) {
  if (!ours(path) || needsNoSync(path)) return;
  const std::lock_guard lock(state().mutex);
  state().unsynced.insert(path);
  state().faults->unsynced = state().unsynced.size();
}

void synced(const std::string& path) {
  if (!ours(path)) return;
  const std::lock_guard lock(state().mutex);
  state().unsynced.erase(path);
  state().faults->unsynced = state().unsynced.size();
}

void renamed(const std::string& from, const std::string& to) {
  const auto above = [](const std::string& path) { return path.substr(0, path.rfind('/')); };
  if (to.find("/~tmp~") != std::string::npos) return;  // waste: it may come back
  {
    const std::lock_guard lock(state().mutex);
    if (state().unsynced.erase(from) != 0) state().unsynced.insert(to);
  }
  changed(above(from));
  changed(above(to));
}

}  // namespace

extern "C" {

ssize_t write(int fd, const void* bytes, size_t size) {
  static const auto real = next<ssize_t (*)(int, const void*, size_t)>("write");
  const std::string path = state().faults == nullptr ? std::string() : pathOf(fd);
  if (fails(path)) return -1;
  changed(path);
  return real(fd, bytes, size);
}

ssize_t pwrite64(int fd, const void* bytes, size_t size, off64_t at) {
  static const auto real = next<ssize_t (*)(int, const void*, size_t, off64_t)>("pwrite64");
  const std::string path = pathOf(fd);
  if (fails(path)) {
    // A disk that fills up takes what fits.
    if (errno == ENOSPC && size > 1) (void)real(fd, bytes, size / 2, at);
    errno = static_cast<int>(state().faults->error.load());
    return -1;
  }
  changed(path);
  return real(fd, bytes, size, at);
}

ssize_t pwrite(int fd, const void* bytes, size_t size, off_t at) {
  return pwrite64(fd, bytes, size, at);
}

int fsync(int fd) {
  static const auto real = next<int (*)(int)>("fsync");
  const std::string path = pathOf(fd);
  if (fails(path)) return -1;
  synced(path);
  return real(fd);
}

int fdatasync(int fd) {
  static const auto real = next<int (*)(int)>("fdatasync");
  const std::string path = pathOf(fd);
  if (fails(path)) return -1;
  synced(path);
  return real(fd);
}

int ftruncate64(int fd, off64_t size) noexcept {
  static const auto real = next<int (*)(int, off64_t)>("ftruncate64");
  const std::string path = pathOf(fd);
  if (fails(path)) return -1;
  changed(path);
  return real(fd, size);
}

int ftruncate(int fd, off_t size) noexcept { return ftruncate64(fd, size); }

int rename(const char* from, const char* to) noexcept {
  static const auto real = next<int (*)(const char*, const char*)>("rename");
  if (fails(to)) return -1;
  const int done = real(from, to);
  if (done == 0) renamed(from, to);
  return done;
}

int mkdir(const char* path, mode_t mode) noexcept {
  static const auto real = next<int (*)(const char*, mode_t)>("mkdir");
  if (fails(path)) return -1;
  return real(path, mode);
}

}  // extern "C"
