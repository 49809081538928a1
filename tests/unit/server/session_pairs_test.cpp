// Questions about pairs in a session: what is answered, in which order, and what is refused.
#include <cmath>

#include "protocol/limits.h"
#include "tests/unit/server/session_fixture.h"

namespace culld::server {
namespace {

class SessionPairs : public SessionTest {
 protected:
  SessionPairs() {
    hello();
    flush();
    inbox.clear();
  }
  static wire::Place at(double x, double z) { return {{x, 0.25, z}, {x, 0.25, z}, 0.0}; }
  /// Does the viewer in front of triangle 1 see what is behind triangles 1 and -5?
  void ask(std::uint64_t id) {
    say(wire::Pairs{{at(1.25, 5)}, {at(1.25, -5), at(-15, -5)}, 0}, id);
  }
  void hide(ObjectId object, std::uint64_t id) {
    say(wire::Edit{0, {{wire::EditKind::kHide, object, {}}}}, id);
  }
  void settlePairs() {
    while (!pairs.empty()) {
      EXPECT_EQ(pairs.size(), 1U) << "one at a time";
      runPairs();
      flush();
    }
    flush();
  }
};

TEST_F(SessionPairs, AreAnsweredBitByBit) {
  ask(40);
  ASSERT_EQ(pairs.size(), 1U);
  settlePairs();
  ASSERT_EQ(inbox.size(), 1U);
  EXPECT_EQ(inbox[0].id, 40U);
  const auto& answer = last<wire::PairsAnswer>();
  EXPECT_EQ(answer.viewers, 1U);
  EXPECT_EQ(answer.targets, 2U);
  EXPECT_EQ(answer.may_see, std::vector<std::uint8_t>{2});
  EXPECT_EQ(answer.scene_version, 1U);
  EXPECT_FALSE(answer.out_of_budget);
  EXPECT_TRUE(session.drained());
}

TEST_F(SessionPairs, SeeTheClientsOwnEditsThatCameBefore) {
  hide(1, 50);
  ask(51);
  EXPECT_TRUE(pairs.empty()) << "the edit is not yet applied";
  EXPECT_FALSE(session.drained());
  runEdits();
  ASSERT_EQ(pairs.size(), 1U);
  settlePairs();
  EXPECT_EQ(last<wire::PairsAnswer>().may_see, std::vector<std::uint8_t>{3});
  EXPECT_EQ(last<wire::PairsAnswer>().scene_version, 2U);
}

TEST_F(SessionPairs, AreAskedAgainOfASceneThatTookTheOldOnesPlace) {
  ask(40);
  scene->replace(scenes::rowOfObjects(1));
  absorb(session.sceneMoved());
  runPairs();
  EXPECT_EQ(count<wire::PairsAnswer>(), 0U);
  settlePairs();
  EXPECT_EQ(last<wire::PairsAnswer>().may_see, std::vector<std::uint8_t>{3});
  EXPECT_TRUE(session.drained());
}

TEST_F(SessionPairs, AreNotAskedAgainForThoseWhoHungUp) {
  ask(40);
  PairsOutcome outcome = server::runPairs(std::move(pairs.at(0)), clock);
  pairs.clear();
  scene->replace(scenes::rowOfObjects(1));
  absorb(session.sceneMoved());
  flush();
  session.hangUp();
  absorb(session.paired(std::move(outcome)));
  EXPECT_TRUE(pairs.empty());
  EXPECT_TRUE(session.drained());
}

/// Goes on by the same time whenever it is read.
class LeapingClock final : public Clock {
 public:
  explicit LeapingClock(std::chrono::nanoseconds leap) : leap_(leap) {}
  std::chrono::nanoseconds now() const noexcept override { return leap_ * ++reads_; }

 private:
  std::chrono::nanoseconds leap_;
  mutable int reads_ = 0;
};

TEST_F(SessionPairs, TakeNoMoreThanTheMostTime) {
  const std::chrono::microseconds most(wire::kMaxPairsTimeUs);
  for (const std::uint32_t asked_us : {0U, 10 * wire::kMaxPairsTimeUs}) {
    for (const bool longer : {false, true}) {
      say(wire::Pairs{{at(1.25, 5)}, {at(1.25, -5)}, asked_us}, 40);
      const LeapingClock leaping(longer ? most + most / 10 : most - most / 10);
      absorb(session.paired(server::runPairs(std::move(pairs.at(0)), leaping)));
      pairs.clear();
      flush();
      EXPECT_EQ(last<wire::PairsAnswer>().out_of_budget, longer) << asked_us;
    }
  }
}

TEST_F(SessionPairs, NameThePlaceThatIsNone) {
  say(wire::Pairs{{at(0, 1), at(std::nan(""), 1)}, {at(1, 1)}, 0}, 40);
  settlePairs();
  EXPECT_EQ(inbox.back().id, 40U);
  expectError(wire::WireCode::kInvalidDemand, "pairs: viewer 1: an empty box");
}

TEST_F(SessionPairs, CountAsRequestsInFlight) {
  for (std::uint64_t i = 0; i < limits.max_requests_in_flight; ++i) ask(40 + i);
  EXPECT_EQ(pairs.size(), 1U);
  EXPECT_TRUE(inbox.empty());
  ask(90);
  expectError(wire::WireCode::kLimitExceeded, "pairs: more than 5 requests in flight");
  settlePairs();
  EXPECT_EQ(count<wire::PairsAnswer>(), limits.max_requests_in_flight);
  ask(91);
  EXPECT_EQ(pairs.size(), 1U);
}

TEST_F(SessionPairs, AreCancelledBeforeTheyBegin) {
  ask(40);
  hide(1, 50);
  ask(41);
  say(wire::Cancel{40}, 900);
  say(wire::Cancel{41}, 901);
  EXPECT_EQ(count<wire::ErrorReply>(), 2U);
  expectError(wire::WireCode::kCancelled, "pairs: cancelled");
  inbox.clear();
  settlePairs();
  runEdits();
  settlePairs();
  EXPECT_EQ(count<wire::PairsAnswer>(), 0U);
  EXPECT_EQ(count<wire::ErrorReply>(), 0U);
  EXPECT_TRUE(session.drained());
}

TEST_F(SessionPairs, AreNotBegunForThoseWhoHungUp) {
  ask(40);
  session.hangUp();
  runPairs();
  EXPECT_TRUE(inbox.empty());
  EXPECT_TRUE(session.drained());
}

TEST_F(SessionPairs, AreRefusedOnTheWayOut) {
  ask(40);
  absorb(session.goAway("bye"));
  ask(41);
  expectError(wire::WireCode::kUnavailable, "pairs: the server is going away");
  settlePairs();
  EXPECT_EQ(last<wire::PairsAnswer>().targets, 2U) << "what was asked before is answered";
  EXPECT_TRUE(session.drained());
}

}  // namespace
}  // namespace culld::server
