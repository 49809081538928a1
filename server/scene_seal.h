// The last bytes of a stored scene: how long it is and its checksum. A file that was cut, flipped,
// or made by something else has no seal that fits, and is not served.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "culling/core/result.h"
#include "server/checksum.h"

namespace culld::server {

constexpr std::size_t kSealBytes = 48;
using Seal = std::array<std::byte, kSealBytes>;

/// "CLDSCENE", u32 version 1, u32 0, u64 size, u64 digest.low, u64 digest.high, u64 checksum of the
/// 40 bytes before; little-endian.
Seal makeSeal(std::uint64_t size, const Digest& digest);

/// What the seal at the end of `file` covers. ERROR: kInvalidInput, one line without a name, which
/// says what does not fit.
Result<std::span<const std::byte>> openSealed(std::span<const std::byte> file);

}  // namespace culld::server
