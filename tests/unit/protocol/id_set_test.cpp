#include "protocol/id_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace culld::protocol {
namespace {

constexpr std::uint32_t kLimit = 100'000;
constexpr std::array kWhole = {Encoding::kRawU32, Encoding::kDeltaVarint,
                               Encoding::kTwoLevelBitset};

IdSet randomSet(std::mt19937& random, std::uint32_t limit, double share) {
  std::bernoulli_distribution in(share);
  IdSet ids;
  for (std::uint32_t id = 0; id < limit; ++id) {
    if (in(random)) ids.push_back(id);
  }
  return ids;
}

std::vector<IdSet> samples() {
  std::mt19937 random(7);
  std::vector<IdSet> sets = {{}, {0}, {kLimit - 1}, {0, kLimit - 1}, {63, 64, 4095, 4096}};
  for (const double share : {0.001, 0.02, 0.3, 1.0}) {
    sets.push_back(randomSet(random, kLimit, share));
  }
  return sets;
}

using Bytes = std::vector<std::uint8_t>;

TEST(IdSet, ComesBackFromEveryEncoding) {
  for (const IdSet& ids : samples()) {
    for (const Encoding encoding : kWhole) {
      const EncodedSet set = encodeAs(encoding, ids);
      const auto back = decodeSet(set.encoding, set.payload, kLimit);
      ASSERT_TRUE(back.ok()) << back.error().message;
      EXPECT_EQ(back.value(), ids);
    }
  }
}

TEST(IdSet, ComesBackFromAChangeOfAnyBaseline) {
  for (const IdSet& before : samples()) {
    for (const IdSet& after : samples()) {
      const EncodedSet change = encodeAddRemove(before, after);
      const auto back = decodeSet(change.encoding, change.payload, kLimit, before);
      ASSERT_TRUE(back.ok()) << back.error().message;
      EXPECT_EQ(back.value(), after);
    }
  }
}

TEST(IdSet, ServerPicksTheSmallestEncoding) {
  for (const IdSet& ids : samples()) {
    const EncodedSet best = encodeSmallest(ids);
    for (const Encoding encoding : kWhole) {
      EXPECT_LE(best.payload.size(), encodeAs(encoding, ids).payload.size());
    }
  }
}

TEST(IdSet, SmallestAgainstABaselineDecodesAndIsNotLargerThanTheWholeOrNearlyNothing) {
  for (const IdSet& before : samples()) {
    for (const IdSet& after : samples()) {
      const EncodedSet best = encodeSmallest(before, after);
      const auto back = decodeSet(best.encoding, best.payload, kLimit, before);
      ASSERT_TRUE(back.ok());
      EXPECT_EQ(back.value(), after);
      EXPECT_LE(best.payload.size(),
                std::max<std::size_t>(encodeSmallest(after).payload.size(), 2 + after.size() / 64));
    }
  }
}

TEST(IdSet, TakesTwoBytesWhenNothingChanged) {
  const IdSet ids = {5, 900, 1000};
  EXPECT_EQ(encodeSmallest(ids, ids).encoding, Encoding::kAddRemove);
  EXPECT_EQ(encodeSmallest(ids, ids).payload.size(), 2U);
}

TEST(IdSet, HasTheBytesThatTheDocumentShows) {
  const IdSet ids = {1, 2, 300};
  EXPECT_EQ(encodeAs(Encoding::kRawU32, ids).payload,
            (Bytes{1, 0, 0, 0, 2, 0, 0, 0, 0x2C, 1, 0, 0}));
  EXPECT_EQ(encodeAs(Encoding::kDeltaVarint, ids).payload, (Bytes{1, 0, 0xA9, 0x02}));
  EXPECT_EQ(encodeAs(Encoding::kTwoLevelBitset, ids).payload,
            (Bytes{1,                                // one group
                   0x11, 0, 0, 0, 0, 0,    0, 0,     // words 0 and 4 are there
                   0x06, 0, 0, 0, 0, 0,    0, 0,     // ids 1 and 2
                   0,    0, 0, 0, 0, 0x10, 0, 0}));  // id 4 * 64 + 44
  EXPECT_EQ(encodeAddRemove(IdSet{2, 7}, ids).payload, (Bytes{2, 1, 0xAA, 0x02, 1, 7}));
}

TEST(SetHash, DoesNotDependOnTheOrderOfComingAndGoing) {
  const IdSet ids = {0, 17, 4'000'000'000U};
  std::uint64_t hash = 0;
  for (const std::uint32_t id : {4'000'000'000U, 0U, 17U}) hash = addToHash(hash, id);
  EXPECT_EQ(hash, setHash(ids));
}

TEST(SetHash, HasTheValuesThatTheDocumentShows) {
  EXPECT_EQ(setHash(IdSet{}), 0U);
  EXPECT_EQ(idHash(0), 0x92CA2F0E514E28B7ULL);
  EXPECT_EQ(setHash(IdSet{1, 2, 300}), 0x0F7E2E44E0EFEB6FULL);
}

TEST(SetHash, TellsNearSetsApart) {
  std::vector<std::uint64_t> hashes;
  for (std::uint32_t a = 0; a < 300; ++a) {
    for (std::uint32_t b = a + 1; b < 300; ++b) hashes.push_back(setHash(IdSet{a, b}));
  }
  std::sort(hashes.begin(), hashes.end());
  EXPECT_EQ(std::adjacent_find(hashes.begin(), hashes.end()), hashes.end());
}

TEST(IdSet, ChangesMayRemoveIdsThatTheSceneNoLongerHas) {
  const IdSet before = {1, 5, 4096};
  const IdSet now = {1, 7};
  const EncodedSet change = encodeAddRemove(before, now);
  const auto set = decodeSet(change.encoding, change.payload, 10, before);
  ASSERT_TRUE(set.ok()) << set.error().message;
  EXPECT_EQ(set.value(), now);
}

struct Hostile {
  const char* what;
  Encoding encoding;
  Bytes payload;
  IdSet baseline;
};

std::vector<Hostile> hostilePayloads() {
  const Bytes word(8, 0xFF);
  Bytes beyond = {1};
  beyond.insert(beyond.end(), 8, 0xFF);
  for (int i = 0; i < 64; ++i) beyond.insert(beyond.end(), 8, 0xFF);
  return {
      {"raw: a torn number", Encoding::kRawU32, {1, 0, 0}, {}},
      {"raw: twice the same id", Encoding::kRawU32, {1, 0, 0, 0, 1, 0, 0, 0}, {}},
      {"raw: descending", Encoding::kRawU32, {2, 0, 0, 0, 1, 0, 0, 0}, {}},
      {"raw: beyond the scene", Encoding::kRawU32, {100, 0, 0, 0}, {}},
      {"varint: cut short", Encoding::kDeltaVarint, {0x80}, {}},
      {"varint: six bytes long", Encoding::kDeltaVarint, {0x80, 0x80, 0x80, 0x80, 0x80, 0}, {}},
      {"varint: more than 32 bits", Encoding::kDeltaVarint, {0xFF, 0xFF, 0xFF, 0xFF, 0x7F}, {}},
      {"varint: sum beyond the scene", Encoding::kDeltaVarint, {99, 0}, {}},
      {"bitset: empty payload", Encoding::kTwoLevelBitset, {}, {}},
      {"bitset: masks missing", Encoding::kTwoLevelBitset, {1}, {}},
      {"bitset: groups beyond the scene",
       Encoding::kTwoLevelBitset,
       {2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
       {}},
      {"bitset: a huge number of groups",
       Encoding::kTwoLevelBitset,
       {0xFF, 0xFF, 0xFF, 0xFF, 15},
       {}},
      {"bitset: words missing", Encoding::kTwoLevelBitset, {1, 1, 0, 0, 0, 0, 0, 0, 0}, {}},
      {"bitset: an empty word",
       Encoding::kTwoLevelBitset,
       {1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
       {}},
      {"bitset: bits beyond the scene", Encoding::kTwoLevelBitset, beyond, {}},
      {"bitset: bytes left over", Encoding::kTwoLevelBitset, {0, 0}, {}},
      {"change: empty payload", Encoding::kAddRemove, {}, {}},
      {"change: counts without ids", Encoding::kAddRemove, {0xFF, 0xFF, 0xFF, 0xFF, 15, 0}, {}},
      {"change: no removed part", Encoding::kAddRemove, {1, 5}, {}},
      {"change: removes what is not there", Encoding::kAddRemove, {0, 1, 5}, {4}},
      {"change: adds what is there", Encoding::kAddRemove, {1, 4, 0}, {4}},
      {"change: bytes left over", Encoding::kAddRemove, {0, 0, 0}, {}},
      {"change: keeps an id beyond the scene", Encoding::kAddRemove, {0, 0}, {150}},
  };
}

TEST(IdSet, RefusesHostilePayloads) {
  for (const Hostile& hostile : hostilePayloads()) {
    const auto set = decodeSet(hostile.encoding, hostile.payload, 100, hostile.baseline);
    EXPECT_FALSE(set.ok()) << hostile.what;
  }
}

TEST(IdSet, SurvivesRandomPayloads) {
  std::mt19937 random(11);
  std::uniform_int_distribution<unsigned> byte(0, 255);
  std::uniform_int_distribution<std::size_t> length(0, 64);
  const IdSet baseline = {1, 5, 70};
  for (int round = 0; round < 50'000; ++round) {
    Bytes payload(length(random));
    for (auto& b : payload) b = static_cast<std::uint8_t>(byte(random));
    const auto encoding = static_cast<Encoding>(round % 4);
    const auto set = decodeSet(encoding, payload, 5000, baseline);
    if (!set.ok()) continue;
    EXPECT_TRUE(std::is_sorted(set.value().begin(), set.value().end()));
    if (!set.value().empty()) {
      EXPECT_LT(set.value().back(), 5000U);
    }
  }
}

}  // namespace
}  // namespace culld::protocol
