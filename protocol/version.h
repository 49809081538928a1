// Versions that both ends of the wire agree on.
#pragma once
#include <cstdint>

namespace culld::protocol {

inline constexpr std::uint32_t kProtocolMin = 1;         ///< oldest that this build speaks
inline constexpr std::uint32_t kProtocolMax = 1;         ///< newest that this build speaks
inline constexpr const char* kSubprotocol = "culld.v1";  ///< Sec-WebSocket-Protocol

}  // namespace culld::protocol
