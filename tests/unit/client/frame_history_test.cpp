#include "client/sdk/frame_history.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "protocol/id_set.h"

namespace culld::client {
namespace {

using Ids = std::vector<std::uint32_t>;
using protocol::Answer;
using protocol::EncodedSet;
using protocol::Encoding;

constexpr std::uint32_t kObjects = 1000;

Answer answerOf(std::uint32_t frame, const Ids& ids, std::uint32_t baseline,
                const EncodedSet& set) {
  Answer answer;
  answer.view = 1;
  answer.frame = frame;
  answer.baseline = baseline;
  answer.scene_objects = kObjects;
  answer.encoding = set.encoding;
  answer.payload = set.payload;
  answer.object_count = static_cast<std::uint32_t>(ids.size());
  answer.set_hash = protocol::setHash(ids);
  return answer;
}

Answer whole(std::uint32_t frame, const Ids& ids) {
  return answerOf(frame, ids, 0, protocol::encodeSmallest(ids));
}

Answer change(std::uint32_t frame, const Ids& ids, std::uint32_t baseline, const Ids& from) {
  return answerOf(frame, ids, baseline, protocol::encodeAddRemove(from, ids));
}

TEST(FrameHistory, HoldsNothingAtFirst) {
  const FrameHistory history;
  EXPECT_EQ(history.newestNumber(), 0U);
  EXPECT_EQ(history.newest(), nullptr);
}

TEST(FrameHistory, TakesAWholeAnswer) {
  FrameHistory history;
  const auto frame = history.apply(whole(1, {3, 5, 900}), 12, 77);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame.value()->visible, (Ids{3, 5, 900}));
  EXPECT_EQ(frame.value()->number, 1U);
  EXPECT_EQ(frame.value()->wire_bytes, 77U);
  EXPECT_FALSE(frame.value()->delta);
  EXPECT_EQ(history.newestNumber(), 1U);
  EXPECT_EQ(history.newest(), frame.value());
}

TEST(FrameHistory, AppliesAChangeToTheFrameItChanges) {
  FrameHistory history;
  const Ids first{1, 2, 3}, second{2, 3, 4}, third{1, 2, 999};
  ASSERT_TRUE(history.apply(whole(1, first), 1, 0).ok());
  ASSERT_TRUE(history.apply(change(2, second, 1, first), 1, 0).ok());
  const auto frame = history.apply(change(3, third, 1, first), 1, 0);  // still refers to frame 1
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame.value()->visible, third);
  EXPECT_TRUE(frame.value()->delta);
}

TEST(FrameHistory, RebuildsEverySetOfALongRandomWalk) {
  std::mt19937 random(7);
  FrameHistory history;
  Ids held, now;
  for (std::uint32_t number = 1; number <= 500; ++number) {
    now.clear();
    for (std::uint32_t id = 0; id < kObjects; ++id) {
      const bool was = std::binary_search(held.begin(), held.end(), id);
      if (random() % 16 == 0 ? !was : was) now.push_back(id);
    }
    const bool fresh = number == 1 || random() % 5 == 0;
    const auto frame =
        history.apply(fresh ? whole(number, now) : change(number, now, number - 1, held), 1, 0);
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    ASSERT_EQ(frame.value()->visible, now);
    history.forgetBefore(number);
    ASSERT_EQ(history.size(), 1U);
    held = now;
  }
}

TEST(FrameHistory, SpreadsTheSeenBitsOverTheVisibleObjects) {
  FrameHistory history;
  Answer answer = whole(1, {0, 1, 2, 3, 4, 5, 6, 7, 8});
  answer.seen = {0x81, 0x01};
  const auto frame = history.apply(answer, 1, 0);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame.value()->seen, (std::vector<std::uint8_t>{1, 0, 0, 0, 0, 0, 0, 1, 1}));
}

struct Misfit {
  const char* what;
  Answer answer;
  const char* error;
};

TEST(FrameHistory, BelievesNothingThatDoesNotFitAndAsksForAWholeAnswer) {
  const Ids held{1, 2, 3}, ids{2, 3, 4};
  Answer wrong_count = whole(2, ids);
  ++wrong_count.object_count;
  Answer wrong_hash = whole(2, ids);
  wrong_hash.set_hash ^= 1U;
  Answer cut = whole(2, ids);
  cut.payload.pop_back();
  Answer beyond = whole(2, ids);
  beyond.scene_objects = 4;
  Answer seen = whole(2, ids);
  seen.seen = {1, 1};
  const Misfit table[] = {
      {"count", wrong_count, "view 1: frame 2: has a wrong count"},
      {"hash", wrong_hash, "view 1: frame 2: has a wrong hash"},
      {"not held", change(2, ids, 9, held), "view 1: frame 2: changes frame 9, which is not held"},
      {"other baseline", change(2, ids, 1, {1, 2, 5}), nullptr},
      {"cut", cut, nullptr},
      {"id beyond the scene", beyond, nullptr},
      {"seen", seen, "view 1: frame 2: marks too few or too many objects as seen"},
      {"old", whole(1, ids), "view 1: frame 1: is older than the one held"},
  };
  for (const Misfit& misfit : table) {
    FrameHistory history;
    ASSERT_TRUE(history.apply(whole(1, held), 1, 0).ok());
    const auto frame = history.apply(misfit.answer, 1, 0);
    ASSERT_FALSE(frame.ok()) << misfit.what;
    EXPECT_FALSE(frame.error().message.empty());
    const std::string message = frame.error().message;
    EXPECT_EQ(message, misfit.error != nullptr ? misfit.error : message) << misfit.what;
    EXPECT_EQ(history.newestNumber(), 0U) << misfit.what;
    EXPECT_TRUE(history.apply(whole(3, ids), 1, 0).ok()) << misfit.what;
  }
}

TEST(FrameHistory, ForgetsOnlyWhatTheServerCannotReferTo) {
  FrameHistory history;
  const Ids a{1}, b{2}, c{3};
  ASSERT_TRUE(history.apply(whole(1, a), 1, 0).ok());
  ASSERT_TRUE(history.apply(whole(2, b), 1, 0).ok());
  history.forgetBefore(2);
  EXPECT_TRUE(history.apply(change(3, c, 2, b), 1, 0).ok());
  EXPECT_FALSE(history.apply(change(4, c, 1, a), 1, 0).ok());
  history.forgetAll();
  EXPECT_EQ(history.newest(), nullptr);
}

}  // namespace
}  // namespace culld::client
