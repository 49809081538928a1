#include "protocol/id_set.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <string>

namespace culld::protocol {
namespace {

static_assert(std::endian::native == std::endian::little, "payloads are little endian");

constexpr std::uint32_t kWordBits = 64;
constexpr std::uint32_t kGroupIds = kWordBits * kWordBits;  ///< ids under one mask word

using Bytes = std::vector<std::uint8_t>;

/// Finalizer of MurmurHash3 (Austin Appleby): a bijection that mixes well and is cheap in
/// JavaScript.
std::uint32_t mix(std::uint32_t x) noexcept {
  x = (x ^ (x >> 16)) * 0x85EBCA6BU;
  x = (x ^ (x >> 13)) * 0xC2B2AE35U;
  return x ^ (x >> 16);
}

void putVarint(Bytes& out, std::uint32_t value) {
  while (value >= 0x80U) {
    out.push_back(static_cast<std::uint8_t>(value | 0x80U));
    value >>= 7;
  }
  out.push_back(static_cast<std::uint8_t>(value));
}

void putGaps(Bytes& out, std::span<const std::uint32_t> ids) {
  std::uint32_t next = 0;  // the smallest id that can follow
  for (const std::uint32_t id : ids) {
    putVarint(out, id - next);
    next = id + 1;
  }
}

void putWord(Bytes& out, std::uint64_t word) {
  const std::size_t at = out.size();
  out.resize(at + sizeof word);
  std::memcpy(out.data() + at, &word, sizeof word);
}

Bytes encodeRaw(std::span<const std::uint32_t> ids) {
  Bytes out(ids.size_bytes());
  if (!ids.empty()) std::memcpy(out.data(), ids.data(), out.size());
  return out;
}

Bytes encodeTwoLevel(std::span<const std::uint32_t> ids) {
  std::vector<std::uint64_t> masks;
  Bytes words;
  for (std::size_t i = 0; i < ids.size();) {
    const std::uint32_t word_index = ids[i] / kWordBits;
    std::uint64_t word = 0;
    for (; i < ids.size() && ids[i] / kWordBits == word_index; ++i) {
      word |= std::uint64_t{1} << (ids[i] % kWordBits);
    }
    masks.resize(word_index / kWordBits + 1);
    masks.back() |= std::uint64_t{1} << (word_index % kWordBits);
    putWord(words, word);
  }
  Bytes out;
  out.reserve(5 + masks.size() * sizeof masks[0] + words.size());
  putVarint(out, static_cast<std::uint32_t>(masks.size()));
  for (const std::uint64_t mask : masks) putWord(out, mask);
  out.insert(out.end(), words.begin(), words.end());
  return out;
}

/// Reads a payload front to back; after the first fault every read gives zero.
class Input {
 public:
  explicit Input(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  bool failed() const noexcept { return failed_; }
  bool done() const noexcept { return bytes_.empty(); }
  std::size_t left() const noexcept { return bytes_.size(); }

  std::uint32_t varint() {
    std::uint64_t value = 0;
    for (unsigned shift = 0; shift < 35 && !bytes_.empty(); shift += 7) {
      const std::uint8_t byte = bytes_.front();
      bytes_ = bytes_.subspan(1);
      value |= std::uint64_t{byte & 0x7FU} << shift;
      if (byte < 0x80U) {
        if (value > 0xFFFFFFFFU) break;
        return static_cast<std::uint32_t>(value);
      }
    }
    failed_ = true;
    return 0;
  }

  std::uint64_t word() {
    std::uint64_t value = 0;
    if (bytes_.size() < sizeof value) {
      failed_ = true;
      return 0;
    }
    std::memcpy(&value, bytes_.data(), sizeof value);
    bytes_ = bytes_.subspan(sizeof value);
    return value;
  }

 private:
  std::span<const std::uint8_t> bytes_;
  bool failed_ = false;
};

Error bad(const char* encoding, const char* what) {
  return {ErrorCode::kInvalidInput, std::string("id set, ") + encoding + ": " + what};
}

/// `count` gaps, each a varint: an id is the one before it plus one plus the gap.
Result<IdSet> readGaps(Input& in, std::uint32_t count, std::uint32_t id_limit) {
  if (count > in.left()) return bad("gaps", "more ids than bytes");
  IdSet ids;
  ids.reserve(count);
  std::uint64_t next = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::uint64_t id = next + in.varint();
    if (in.failed()) return bad("gaps", "cut short or too long a number");
    if (id >= id_limit) return bad("gaps", "an id beyond the scene");
    ids.push_back(static_cast<std::uint32_t>(id));
    next = id + 1;
  }
  return ids;
}

Result<IdSet> decodeRaw(std::span<const std::uint8_t> payload, std::uint32_t id_limit) {
  if (payload.size() % sizeof(std::uint32_t) != 0) return bad("raw", "not a multiple of 4 bytes");
  IdSet ids(payload.size() / sizeof(std::uint32_t));
  if (!ids.empty()) std::memcpy(ids.data(), payload.data(), payload.size());
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] >= id_limit) return bad("raw", "an id beyond the scene");
    if (i > 0 && ids[i] <= ids[i - 1]) return bad("raw", "ids not ascending");
  }
  return ids;
}

Result<IdSet> decodeVarint(std::span<const std::uint8_t> payload, std::uint32_t id_limit) {
  // Each id ends with the one byte of its number whose top bit is clear.
  const auto ends =
      std::count_if(payload.begin(), payload.end(), [](std::uint8_t byte) { return byte < 0x80U; });
  Input in(payload);
  auto ids = readGaps(in, static_cast<std::uint32_t>(ends), id_limit);
  if (ids && !in.done()) return bad("gaps", "bytes left over");
  return ids;
}

Result<IdSet> decodeTwoLevel(std::span<const std::uint8_t> payload, std::uint32_t id_limit) {
  Input in(payload);
  const std::uint32_t groups = in.varint();
  if (in.failed()) return bad("bitset", "cut short");
  if (groups > in.left() / sizeof(std::uint64_t)) return bad("bitset", "cut short");
  if (groups > (std::uint64_t{id_limit} + kGroupIds - 1) / kGroupIds) {
    return bad("bitset", "more groups than the scene has");
  }
  std::vector<std::uint64_t> masks(groups);
  for (std::uint64_t& mask : masks) mask = in.word();
  IdSet ids;
  for (std::uint32_t group = 0; group < groups; ++group) {
    for (std::uint64_t mask = masks[group]; mask != 0; mask &= mask - 1) {
      const auto word_index =
          group * kWordBits + static_cast<std::uint32_t>(std::countr_zero(mask));
      std::uint64_t word = in.word();
      if (in.failed()) return bad("bitset", "cut short");
      if (word == 0) return bad("bitset", "an empty word");
      for (; word != 0; word &= word - 1) {
        const auto id = word_index * kWordBits + static_cast<std::uint32_t>(std::countr_zero(word));
        if (id >= id_limit) return bad("bitset", "an id beyond the scene");
        ids.push_back(id);
      }
    }
  }
  if (!in.done()) return bad("bitset", "bytes left over");
  return ids;
}

Result<IdSet> decodeAddRemove(std::span<const std::uint8_t> payload, std::uint32_t id_limit,
                              std::span<const std::uint32_t> baseline) {
  Input in(payload);
  const std::uint32_t added_count = in.varint();
  if (in.failed()) return bad("change", "cut short");
  auto added = readGaps(in, added_count, id_limit);
  if (!added) return added;
  const std::uint32_t removed_count = in.varint();
  if (in.failed()) return bad("change", "cut short");
  // Ids that the scene no longer has may go; below, all removed ones must be in the baseline.
  auto removed = readGaps(in, removed_count, std::numeric_limits<std::uint32_t>::max());
  if (!removed) return removed;
  if (!in.done()) return bad("change", "bytes left over");

  if (removed_count > baseline.size()) return bad("change", "removes what the baseline has not");
  IdSet kept;
  kept.reserve(baseline.size());
  std::set_difference(baseline.begin(), baseline.end(), removed.value().begin(),
                      removed.value().end(), std::back_inserter(kept));
  if (kept.size() != baseline.size() - removed_count) {
    return bad("change", "removes what the baseline has not");
  }
  IdSet ids;
  ids.reserve(kept.size() + added_count);
  std::set_union(kept.begin(), kept.end(), added.value().begin(), added.value().end(),
                 std::back_inserter(ids));
  if (ids.size() != kept.size() + added_count) {
    return bad("change", "adds what the baseline has");
  }
  if (!ids.empty() && ids.back() >= id_limit) return bad("change", "an id beyond the scene");
  return ids;
}

}  // namespace

std::uint64_t idHash(std::uint32_t id) noexcept {
  const std::uint64_t high = mix(id ^ 0x9E3779B9U);
  return (high << 32) | mix(id + 1U);
}

std::uint64_t addToHash(std::uint64_t hash, std::uint32_t id) noexcept {
  const std::uint64_t more = idHash(id);
  const std::uint64_t high = (hash >> 32) + (more >> 32);
  return (high << 32) | ((hash + more) & 0xFFFFFFFFU);
}

std::uint64_t setHash(std::span<const std::uint32_t> ids) noexcept {
  std::uint32_t high = 0;
  std::uint32_t low = 0;
  for (const std::uint32_t id : ids) {
    high += mix(id ^ 0x9E3779B9U);
    low += mix(id + 1U);
  }
  return (std::uint64_t{high} << 32) | low;
}

EncodedSet encodeAs(Encoding encoding, std::span<const std::uint32_t> ids) {
  if (encoding == Encoding::kTwoLevelBitset) return {encoding, encodeTwoLevel(ids)};
  if (encoding == Encoding::kDeltaVarint) {
    EncodedSet out{encoding, {}};
    out.payload.reserve(ids.size() + ids.size() / 4);
    putGaps(out.payload, ids);
    return out;
  }
  return {Encoding::kRawU32, encodeRaw(ids)};
}

EncodedSet encodeAddRemove(std::span<const std::uint32_t> baseline,
                           std::span<const std::uint32_t> ids) {
  IdSet added;
  IdSet removed;
  std::set_difference(ids.begin(), ids.end(), baseline.begin(), baseline.end(),
                      std::back_inserter(added));
  std::set_difference(baseline.begin(), baseline.end(), ids.begin(), ids.end(),
                      std::back_inserter(removed));
  EncodedSet out{Encoding::kAddRemove, {}};
  putVarint(out.payload, static_cast<std::uint32_t>(added.size()));
  putGaps(out.payload, added);
  putVarint(out.payload, static_cast<std::uint32_t>(removed.size()));
  putGaps(out.payload, removed);
  return out;
}

EncodedSet encodeSmallest(std::span<const std::uint32_t> ids) {
  EncodedSet best = encodeAs(Encoding::kDeltaVarint, ids);
  EncodedSet bits = encodeAs(Encoding::kTwoLevelBitset, ids);
  if (bits.payload.size() < best.payload.size()) best = std::move(bits);
  if (ids.size_bytes() < best.payload.size()) best = encodeAs(Encoding::kRawU32, ids);
  return best;
}

EncodedSet encodeSmallest(std::span<const std::uint32_t> baseline,
                          std::span<const std::uint32_t> ids) {
  EncodedSet change = encodeAddRemove(baseline, ids);
  // Two bytes say "nothing changed"; a change this small cannot be beaten by a whole set.
  if (change.payload.size() <= std::max<std::size_t>(2, ids.size() / 64)) return change;
  EncodedSet whole = encodeSmallest(ids);
  return whole.payload.size() < change.payload.size() ? whole : change;
}

Result<IdSet> decodeSet(Encoding encoding, std::span<const std::uint8_t> payload,
                        std::uint32_t id_limit, std::span<const std::uint32_t> baseline) {
  switch (encoding) {
    case Encoding::kRawU32:
      return decodeRaw(payload, id_limit);
    case Encoding::kDeltaVarint:
      return decodeVarint(payload, id_limit);
    case Encoding::kTwoLevelBitset:
      return decodeTwoLevel(payload, id_limit);
    case Encoding::kAddRemove:
      return decodeAddRemove(payload, id_limit, baseline);
  }
  return invalidInput("id set: unknown encoding");
}

}  // namespace culld::protocol
