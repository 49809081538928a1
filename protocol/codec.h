// Messages to bytes and back. Bytes are hostile: size, FlatBuffers verifier, then meaning are
// checked.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "protocol/messages.h"

namespace culld::protocol {

std::vector<std::uint8_t> encode(const Message& message);

/// GUARANTEES: enumerators known, strings within kMaxTextBytes, arrays of the right length. Whether
/// numbers make a camera is the server's to judge. ERROR: kInvalidInput (malformed), kLimitExceeded
/// (too large), kUnsupported (unknown body). `request_id`, if given, receives the message's id as
/// far as it could be read (else 0).
Result<Message> decode(std::span<const std::uint8_t> bytes, std::size_t max_bytes,
                       std::uint64_t* request_id = nullptr);

}  // namespace culld::protocol
