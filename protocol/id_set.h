// Sets of object ids on the wire: four encodings and a hash (docs/protocol.md "Sets of ids").
// Sets are ascending and unique vectors; the encodings are the ones that measured smallest and
// cheapest on visible sets of real scenes.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "protocol/messages.h"

namespace culld::protocol {

using IdSet = std::vector<std::uint32_t>;  ///< ascending, unique

/// One id's share of a set hash. The hash of a set is the lane-wise sum (both halves modulo 2^32)
/// over its ids, so it can be kept up to date as ids come and go, in any order.
std::uint64_t idHash(std::uint32_t id) noexcept;
std::uint64_t addToHash(std::uint64_t hash, std::uint32_t id) noexcept;
std::uint64_t setHash(std::span<const std::uint32_t> ids) noexcept;

struct EncodedSet {
  Encoding encoding = Encoding::kRawU32;
  std::vector<std::uint8_t> payload;
};

/// REQUIRES: ids ascending and unique; not kAddRemove.
EncodedSet encodeAs(Encoding encoding, std::span<const std::uint32_t> ids);
/// The change from `baseline` to `ids`. REQUIRES: both ascending and unique.
EncodedSet encodeAddRemove(std::span<const std::uint32_t> baseline,
                           std::span<const std::uint32_t> ids);
/// The smallest encoding of `ids` that needs no baseline.
EncodedSet encodeSmallest(std::span<const std::uint32_t> ids);
/// The smallest of all. REQUIRES: the receiver holds `baseline`. Check `.encoding`: only kAddRemove
/// refers to the baseline.
EncodedSet encodeSmallest(std::span<const std::uint32_t> baseline,
                          std::span<const std::uint32_t> ids);

/// GUARANTEES: the result is ascending, unique, below `id_limit`, and the whole payload was used.
/// `baseline` is read by kAddRemove only. ERROR: kInvalidInput. COST: O(payload + baseline +
/// result).
Result<IdSet> decodeSet(Encoding encoding, std::span<const std::uint8_t> payload,
                        std::uint32_t id_limit, std::span<const std::uint32_t> baseline = {});

}  // namespace culld::protocol
