#include "protocol/messages.h"

#include <array>
#include <string_view>

namespace culld::protocol {

std::string wireCodeName(WireCode code) {
  static constexpr std::array<std::string_view, 19> kNames = {
      "none",           "bad-message",    "unsupported-version",
      "hello-expected", "unknown-scene",  "unknown-method",
      "unknown-view",   "invalid-camera", "invalid-demand",
      "invalid-edit",   "limit-exceeded", "unsupported",
      "conflict",       "internal",       "unavailable",
      "forbidden",      "quota-exceeded", "deadline-exceeded",
      "cancelled"};
  const auto index = static_cast<std::size_t>(code);
  if (index < kNames.size()) return std::string(kNames[index]);
  return "error " + std::to_string(index);
}

}  // namespace culld::protocol
