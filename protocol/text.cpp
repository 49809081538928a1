#include "protocol/text.h"

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace culld::protocol {

std::string oneLine(std::string_view text) {
  static constexpr std::string_view kHex = "0123456789abcdef";
  std::string line;
  line.reserve(text.size());
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte >= 0x20 && byte != 0x7F) {
      line += c;
    } else if (c == '\n' || c == '\r' || c == '\t') {
      line += {'\\', c == '\n' ? 'n' : c == '\r' ? 'r' : 't'};
    } else {
      line += {'\\', 'x', kHex[byte >> 4U], kHex[byte & 15U]};
    }
  }
  return line;
}

Result<void> flushStdout() {
  errno = 0;
  const bool flushed = std::fflush(stdout) == 0;
  if (flushed && std::ferror(stdout) == 0) return Done{};
  const std::string why = errno != 0 ? std::strerror(errno) : "an earlier part was lost";
  return Error{ErrorCode::kIo, "stdout: cannot write: " + why};
}

}  // namespace culld::protocol
