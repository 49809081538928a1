// What one message may ask for at most. A server tells its own limits in Welcome; these are the
// defaults, and no message beyond them is decoded (docs/protocol.md "Limits").
#pragma once
#include <cstddef>
#include <cstdint>

namespace culld::protocol {

inline constexpr std::size_t kMaxRequestBytes = std::size_t{256} << 10;  ///< client to server
inline constexpr std::size_t kMaxReplyBytes = std::size_t{64} << 20;     ///< server to client
inline constexpr std::size_t kMaxTextBytes = 4096;           ///< any string of a message
inline constexpr std::uint32_t kMaxViews = 64;               ///< open at once on one connection
inline constexpr std::uint32_t kMaxEdits = 1024;             ///< in one Edit
inline constexpr std::size_t kMaxPairs = 65'536;             ///< viewers x targets of one Pairs
inline constexpr std::uint32_t kMaxPairsTimeUs = 2'000'000;  ///< of a worker, for one Pairs
inline constexpr std::uint32_t kMaxObjects = 16'000'000;     ///< ids are below this
inline constexpr std::uint32_t kMaxImageSide = 65536;

}  // namespace culld::protocol
