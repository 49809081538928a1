#include "culling/scene/gltf_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>

#include "culling/scene/gltf_failure.h"

namespace culld::gltf {
namespace {

constexpr std::size_t kMaxShown = 200;

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int get() const noexcept { return fd_; }

 private:
  int fd_;
};

[[noreturn]] void failWithErrno(int error) {
  const ErrorCode code =
      error == ENOENT || error == ENOTDIR ? ErrorCode::kNotFound : ErrorCode::kIo;
  fail(code, std::generic_category().message(error));
}

void readAll(int fd, OwnedBytes& bytes) {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t n = ::read(fd, bytes.data() + done, bytes.size() - done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) failWithErrno(errno);
    if (n == 0) fail(ErrorCode::kIo, "the file became shorter while it was read");
    done += static_cast<std::size_t>(n);
  }
}

}  // namespace

OwnedBytes readRegularFile(const std::string& path, std::uint64_t wanted, std::uint64_t at_most) {
  // Without O_NONBLOCK, opening a pipe would wait for its writer.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0) failWithErrno(errno);
  struct stat info {};
  if (::fstat(file.get(), &info) != 0) failWithErrno(errno);
  if (!S_ISREG(info.st_mode)) fail(ErrorCode::kInvalidInput, "is not a regular file");
  const auto size = static_cast<std::uint64_t>(info.st_size);
  if (wanted > size) {
    fail(ErrorCode::kInvalidInput,
         "has " + std::to_string(size) + " bytes, " + std::to_string(wanted) + " are needed");
  }
  if (wanted == 0) wanted = size;
  if (wanted > at_most) {
    fail(ErrorCode::kLimit,
         std::to_string(wanted) + " bytes > limit of " + std::to_string(at_most));
  }
  OwnedBytes bytes(wanted);
  readAll(file.get(), bytes);
  return bytes;
}

std::string shown(const std::string& text) {
  std::string line = text.substr(0, kMaxShown);
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  }
  if (text.size() > kMaxShown) line += "...";
  return line;
}

}  // namespace culld::gltf
