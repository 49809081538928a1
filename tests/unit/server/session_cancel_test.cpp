// Cameras and edits that are given up: cancelled, too late, too many, or of a view that is closed.
#include "tests/unit/server/session_fixture.h"

namespace culld::server {
namespace {

using namespace std::chrono_literals;

class SessionCancel : public SessionTest {
 protected:
  SessionCancel() {
    hello();
    open(1);
    flush();
    inbox.clear();
  }
  void cancel(std::uint64_t request_id) { say(wire::Cancel{request_id}, 900); }
  void cameraWithin(std::chrono::microseconds deadline, std::uint64_t id,
                    std::chrono::microseconds budget = 0us) {
    wire::CameraUpdate update{1, cameraAt(0), {}, 0};
    update.deadline_us = static_cast<std::uint32_t>(deadline.count());
    update.demand.time_us = static_cast<std::uint32_t>(budget.count());
    say(update, id);
  }
  void hide(ObjectId object, std::uint64_t id) {
    say(wire::Edit{0, {{wire::EditKind::kHide, object, {}}}}, id);
  }
  void tickAt(Time now) {
    clock.time = now;
    absorb(session.tick(now));
  }
  std::vector<std::uint64_t> repliedIds() const {
    std::vector<std::uint64_t> ids;
    for (const wire::Message& message : inbox) ids.push_back(message.id);
    return ids;
  }
  using Ids = std::vector<std::uint64_t>;
};

TEST_F(SessionCancel, AWaitingCameraIsDroppedAndSaysSo) {
  camera(0, 10);
  camera(1, 11);
  cancel(11);
  expectError(wire::WireCode::kCancelled, "view 1: cancelled");
  settle();
  EXPECT_EQ(repliedIds(), (Ids{11, 10}));
  EXPECT_EQ(last<wire::Answer>().superseded, 0U);
}

TEST_F(SessionCancel, ARunningCullIsAnsweredCancelledAtOnceAndNotSent) {
  camera(0, 10);
  camera(1, 11);
  cancel(10);
  expectError(wire::WireCode::kCancelled, "view 1: cancelled");
  EXPECT_EQ(inbox.back().id, 10U);
  ASSERT_EQ(culls.size(), 1U) << "one cull at a time, given up or not";
  settle();
  EXPECT_EQ(repliedIds(), (Ids{10, 11}));
}

TEST_F(SessionCancel, ACullThatHasNotBegunCostsNothing) {
  int culled = 0;
  fake.on_cull = [&culled] { ++culled; };
  camera(0, 10);
  cancel(10);
  settle();
  EXPECT_EQ(culled, 0);
}

TEST_F(SessionCancel, CancelledFramesAreNoBaselines) {
  camera(0, 10);
  cancel(10);
  settle();
  camera(0, 11, 1);  // as if frame 1 had come
  settle();
  EXPECT_EQ(last<wire::Answer>().baseline, 0U);
  EXPECT_EQ(last<wire::Answer>().frame, 2U);
}

TEST_F(SessionCancel, SupersededCamerasAreCountedPastACancelledOne) {
  camera(0, 10);
  for (std::uint64_t id = 11; id <= 14; ++id) camera(1, id);
  runCulls();
  flush();  // 14 runs, 3 superseded
  cancel(14);
  camera(1, 15);
  settle();
  EXPECT_EQ(inbox.back().id, 15U);
  EXPECT_EQ(last<wire::Answer>().superseded, 3U);
}

TEST_F(SessionCancel, AWaitingEditIsNotAppliedButARunningOneIs) {
  hide(0, 10);
  hide(3, 11);
  cancel(10);
  cancel(11);
  expectError(wire::WireCode::kCancelled, "edit: cancelled");
  settle();
  EXPECT_EQ(last<wire::Edited>().scene_version, 2U);
  camera(0, 12);
  settle();
  EXPECT_EQ(last<wire::Answer>().object_count, 99U) << "object 0 went, object 3 did not";
}

TEST_F(SessionCancel, WhatIsAnsweredOrUnknownIsLeftAlone) {
  camera(0, 10);
  runCulls();  // the answer is on its way
  cancel(10);
  cancel(4711);
  settle();
  EXPECT_EQ(repliedIds(), Ids{10});
  EXPECT_EQ(count<wire::Answer>(), 1U);
}

TEST_F(SessionCancel, TwiceIsRepliedToOnce) {
  camera(0, 10);
  cancel(10);
  cancel(10);
  settle();
  EXPECT_EQ(repliedIds(), Ids{10});
}

TEST_F(SessionCancel, ACancelledCameraDoesNotComeBackWithANewScene) {
  camera(0, 10);
  cancel(10);
  scene->replace(rowOfObjects(30));
  absorb(session.sceneMoved());
  settle();
  EXPECT_EQ(count<wire::Answer>(), 0U);
  EXPECT_TRUE(session.drained());
}

TEST_F(SessionCancel, TheCullOfAClosedOrReopenedViewIsNotBegun) {
  int culled = 0;
  fake.on_cull = [&culled] { ++culled; };
  camera(0, 10);
  open(1);
  camera(0, 11);
  say(wire::CloseView{1}, 12);
  settle();
  EXPECT_EQ(culled, 0);
}

TEST_F(SessionCancel, NorIsOneThatNobodyWillRead) {
  int culled = 0;
  fake.on_cull = [&culled] { ++culled; };
  camera(0, 10);
  camera(0, 11);
  session.hangUp();
  settle();
  EXPECT_EQ(culled, 0);
  EXPECT_TRUE(session.drained());
}

TEST_F(SessionCancel, ACameraThatWaitsPastItsDeadlineIsRefusedAtTheDeadline) {
  camera(0, 10);
  cameraWithin(500us, 11);
  EXPECT_EQ(session.nextTick(), Time(500us));
  tickAt(499us);
  EXPECT_EQ(repliedIds(), Ids{});
  tickAt(500us);
  expectError(wire::WireCode::kDeadlineExceeded, "view 1: the cull could not begin");
  EXPECT_EQ(session.nextTick(), std::nullopt);
  settle();
  EXPECT_EQ(repliedIds(), (Ids{11, 10}));
}

TEST_F(SessionCancel, SoIsOneThatWaitsForAWorker) {
  int culled = 0;
  fake.on_cull = [&culled] { ++culled; };
  cameraWithin(500us, 10);
  tickAt(600us);
  expectError(wire::WireCode::kDeadlineExceeded, "view 1");
  settle();
  EXPECT_EQ(culled, 0);
  EXPECT_EQ(repliedIds(), Ids{10});
}

TEST_F(SessionCancel, AWorkerThatComesTooLateSaysSoToo) {
  cameraWithin(500us, 10);
  clock.time = 500us;  // and no tick came
  settle();
  expectError(wire::WireCode::kDeadlineExceeded, "view 1");
  EXPECT_EQ(repliedIds(), Ids{10});
}

TEST_F(SessionCancel, PreparingAMethodCountsTowardsTheDeadline) {
  fake.on_prepare = [this] { clock.time = 2ms; };
  cameraWithin(1ms, 10);
  settle();
  expectError(wire::WireCode::kDeadlineExceeded, "view 1");
}

TEST_F(SessionCancel, WhatIsLeftUntilTheDeadlineBoundsTheCull) {
  std::vector<std::chrono::nanoseconds> budgets;
  fake.on_demand = [&budgets](const Demand& demand) { budgets.push_back(demand.time); };
  cameraWithin(500us, 10);
  clock.time = 200us;
  settle();
  cameraWithin(500us, 11, 100us);
  settle();
  cameraWithin(0us, 12, 900us);
  settle();
  cameraWithin(0us, 13);
  settle();
  using Budgets = std::vector<std::chrono::nanoseconds>;
  EXPECT_EQ(budgets, (Budgets{300us, 100us, 900us, 0us}));
}

TEST_F(SessionCancel, ACullThatHasBegunIsAnsweredAfterItsDeadline) {
  fake.on_cull = [this] { tickAt(600us); };
  cameraWithin(500us, 10);
  settle();
  EXPECT_EQ(repliedIds(), Ids{10});
  EXPECT_EQ(count<wire::Answer>(), 1U);
  EXPECT_EQ(session.nextTick(), std::nullopt);
}

TEST_F(SessionCancel, AskingForADeadlineAgainIsANewCamera) {
  camera(0, 10);
  cameraWithin(500us, 11);
  camera(0, 12);  // supersedes it: the deadline goes with it
  EXPECT_EQ(session.nextTick(), std::nullopt);
  settle();
  EXPECT_EQ(inbox.back().id, 12U);
}

TEST_F(SessionCancel, LimitsRequestsInFlightHoweverViewsComeAndGo) {
  // The fixture allows five: two culls of closed views, a third, its successor, and an edit.
  for (std::uint64_t id = 10; id < 13; ++id) {
    open(1);
    camera(0, id);
  }
  camera(0, 13);
  hide(0, 14);
  open(2);
  camera(0, 15, 0, 2);
  expectError(wire::WireCode::kLimitExceeded, "view 2: more than 5 requests in flight");
  hide(0, 16);
  expectError(wire::WireCode::kLimitExceeded, "edit: more than 5 requests in flight");
  camera(0, 17);  // takes the place of 13
  EXPECT_EQ(inbox.back().id, 16U);
  settle();
  EXPECT_EQ(inbox.back().id, 17U);
  camera(0, 18, 0, 2);
  settle();
  EXPECT_EQ(inbox.back().id, 18U) << "and then there is room again";
}

TEST_F(SessionCancel, WelcomeTellsOfTheFeaturesAndEveryLimit) {
  Session fresh{scene, limits, "culld/test", Time(0)};
  absorb(fresh.receive(wire::encode({1, wire::Hello{1, 1, "test"}}), Time(0)));
  const auto& welcome = last<wire::Welcome>();
  EXPECT_EQ(welcome.features, wire::kFeatureCancel | wire::kFeatureDeadlines | wire::kFeaturePairs);
  EXPECT_EQ(welcome.limits, (wire::Limits{262'144, 3, 4, 60'000, 5, 2, limits.max_messages_per_s,
                                          4096, 65'536, 3}));
}

}  // namespace
}  // namespace culld::server
