#include <limits>

#include "protocol/version.h"
#include "tests/unit/server/session_fixture.h"

namespace culld::server {
namespace {

using namespace std::chrono_literals;

TEST_F(SessionTest, WelcomesWithSceneAndLimits) {
  say(wire::Hello{1, 7, "test"}, 42);
  const auto& welcome = last<wire::Welcome>();
  EXPECT_EQ(inbox.back().id, 42U);
  EXPECT_EQ(welcome.protocol, wire::kProtocolMax);
  EXPECT_EQ(welcome.scene.name, "row");
  EXPECT_EQ(welcome.scene.objects, 300U);
  EXPECT_EQ(welcome.limits.max_views, 3U);
}

TEST_F(SessionTest, NamesTheVersionsWhenTheyDoNotMeetAndLivesOn) {
  say(wire::Hello{5, 9, "test"}, 1);
  expectError(wire::WireCode::kUnsupportedVersion, "protocol 5 to 9");
  hello();
}

TEST_F(SessionTest, WantsHelloFirst) {
  open(1);
  expectError(wire::WireCode::kHelloExpected, "Hello");
  hello();
}

TEST_F(SessionTest, ClosesWithoutHelloInTime) {
  absorb(session.tick(4999ms));
  EXPECT_FALSE(closed);
  absorb(session.tick(5000ms));
  ASSERT_TRUE(closed);
  EXPECT_EQ(closed->code, 1008);
}

TEST_F(SessionTest, AnswersACamera) {
  hello();
  open(1);
  EXPECT_EQ(last<wire::ViewOpened>().method, "fake");
  camera(1.0, 10);
  clock.time = 5us;
  runCulls();
  const auto& answer = last<wire::Answer>();
  EXPECT_EQ(inbox.back().id, 10U);
  EXPECT_EQ(answer.frame, 1U);
  EXPECT_EQ(answer.baseline, 0U);
  const auto set = wire::decodeSet(answer.encoding, answer.payload, answer.scene_objects);
  ASSERT_TRUE(set.ok());
  EXPECT_EQ(set.value(), fakeVisible(*scene->current()->snapshot(), 1.0));
  EXPECT_EQ(answer.set_hash, wire::setHash(set.value()));
  EXPECT_EQ(answer.stats.queue_ns, 5000U);
}

TEST_F(SessionTest, SendsSeenOnlyWhenAsked) {
  hello();
  open(1);
  say(wire::OpenView{2, "", true}, 3);
  camera(0, 10, 0, 1);
  camera(0, 11, 0, 2);
  runCulls();
  EXPECT_TRUE(std::get<wire::Answer>(inbox[inbox.size() - 2].body).seen.empty());
  EXPECT_EQ(last<wire::Answer>().seen.size(), (last<wire::Answer>().object_count + 7) / 8);
}

TEST_F(SessionTest, AnswersOnlyTheNewestOfManyCameras) {
  hello();
  open(1);
  camera(0, 10);  // runs
  for (std::uint64_t id = 11; id <= 20; ++id) camera(static_cast<double>(id), id);
  ASSERT_EQ(culls.size(), 1U);
  settle();
  ASSERT_EQ(count<wire::Answer>(), 2U);
  EXPECT_EQ(inbox.back().id, 20U);
  EXPECT_EQ(last<wire::Answer>().superseded, 9U);
}

TEST_F(SessionTest, HoldsBackWhileAnAnswerOfTheViewIsUnsent) {
  hello();
  open(1);
  flush();
  camera(0, 10);
  runCulls();
  for (std::uint64_t id = 11; id <= 13; ++id) camera(1, id);
  EXPECT_TRUE(culls.empty());
  flush();
  EXPECT_EQ(culls.size(), 1U);
}

TEST_F(SessionTest, SendsChangesAgainstTheAcknowledgedFrame) {
  hello();
  open(1);
  camera(0, 10);
  settle();
  camera(0, 11, 1);
  settle();
  EXPECT_EQ(last<wire::Answer>().baseline, 1U);
  EXPECT_EQ(last<wire::Answer>().payload.size(), 2U);
  camera(0, 12, 1);
  settle();
  EXPECT_EQ(last<wire::Answer>().baseline, 1U) << "frame 2 was not acknowledged";
  camera(0, 13, 0);
  settle();
  EXPECT_EQ(last<wire::Answer>().baseline, 0U) << "the client holds nothing";
  camera(0, 14, 77);
  settle();
  EXPECT_EQ(last<wire::Answer>().baseline, 0U) << "no such frame was sent";
}

TEST_F(SessionTest, ForgetsBaselinesPastTheLimit) {
  hello();
  open(1);
  for (std::uint64_t id = 10; id < 15; ++id) {
    camera(0, id, 1);  // frame 1 is held for three further frames
    settle();
  }
  EXPECT_EQ(last<wire::Answer>().baseline, 0U);
}

TEST_F(SessionTest, ForgetsBaselinesOfTooManyIds) {
  limits.kept_frames = 100;
  limits.kept_ids = 250;  // two sets of a hundred
  Session tight{scene, limits, "culld/test", Time(0)};
  const auto ask = [&](std::uint64_t id, std::uint32_t ack) {
    absorb(tight.receive(wire::encode({id, wire::CameraUpdate{1, cameraAt(0), {}, ack}}), {}));
    for (CullJob& job : std::exchange(culls, {})) absorb(tight.culled(runCull(job, clock)));
    for (const SendTag& tag : std::exchange(unsent, {})) absorb(tight.sent(tag));
    return last<wire::Answer>();
  };
  absorb(tight.receive(wire::encode({1, wire::Hello{1, 1, "test"}}), Time(0)));
  absorb(tight.receive(wire::encode({2, wire::OpenView{1, "", false}}), Time(0)));
  ask(10, 0);
  EXPECT_EQ(ask(11, 1).baseline, 1U);
  EXPECT_EQ(ask(12, 1).baseline, 1U) << "frames 1 and 2";
  EXPECT_EQ(ask(13, 1).baseline, 0U) << "frames 2 and 3";
  EXPECT_EQ(ask(14, 4).baseline, 4U);
}

TEST_F(SessionTest, ChangesAddUpToTheFullSets) {
  hello();
  open(1);
  std::map<std::uint32_t, wire::IdSet> held;
  std::uint32_t ack = 0;
  for (std::uint64_t id = 10; id < 60; ++id) {
    const double x = static_cast<double>((id * 7) % 5);
    camera(x, id, ack);
    settle();
    const auto& answer = last<wire::Answer>();
    const auto set = wire::decodeSet(answer.encoding, answer.payload, answer.scene_objects,
                                     held[answer.baseline]);
    ASSERT_TRUE(set.ok());
    EXPECT_EQ(set.value(), fakeVisible(*scene->current()->snapshot(), x));
    EXPECT_EQ(answer.set_hash, wire::setHash(set.value()));
    held[answer.frame] = set.value();
    if (id % 3 != 0) ack = answer.frame;
  }
}

TEST_F(SessionTest, NamesWhatIsWrongWithACameraAndLivesOn) {
  hello();
  open(1);
  wire::Camera nan = cameraAt(std::numeric_limits<double>::quiet_NaN());
  say(wire::CameraUpdate{1, nan, {}, 0}, 10);
  expectError(wire::WireCode::kInvalidCamera, "view 1: ");
  wire::Camera singular;
  singular.pose = wire::Matrices{};
  say(wire::CameraUpdate{1, singular, {}, 0}, 11);
  expectError(wire::WireCode::kInvalidCamera, "view 1: ");
  wire::Camera wide = cameraAt(0);
  wide.width_px = wire::kMaxImageSide + 1;
  say(wire::CameraUpdate{1, wide, {}, 0}, 12);
  expectError(wire::WireCode::kInvalidCamera, "view 1: ");
  wire::Camera flat = cameraAt(0);
  flat.height_px = 0;
  say(wire::CameraUpdate{1, flat, {}, 0}, 12);
  expectError(wire::WireCode::kInvalidCamera, "view 1: ");
  say(wire::CameraUpdate{1, cameraAt(0), {wire::Guarantee::kHole, -1.0F, 0, 0}, 0}, 13);
  expectError(wire::WireCode::kInvalidDemand, "hole_px");
  EXPECT_TRUE(culls.empty());
  camera(0, 14);
  settle();
  EXPECT_EQ(count<wire::Answer>(), 1U);
}

TEST_F(SessionTest, AnInvalidCameraDoesNotReplaceAWaitingOne) {
  hello();
  open(1);
  camera(0, 10);
  camera(1, 11);
  camera(std::numeric_limits<double>::infinity(), 12);
  settle();
  EXPECT_EQ(inbox.back().id, 11U);
}

TEST_F(SessionTest, NamesUnknownViewsAndMethods) {
  hello();
  camera(0, 10, 0, 9);
  expectError(wire::WireCode::kUnknownView, "view 9");
  say(wire::CloseView{9}, 11);
  expectError(wire::WireCode::kUnknownView, "view 9");
  open(1, "magic");
  expectError(wire::WireCode::kUnknownMethod, "\"magic\"");
  fake.refusal = "no triangles";
  open(1, "fake");
  expectError(wire::WireCode::kUnsupported, "no triangles");
}

TEST_F(SessionTest, ReportsAMethodThatCannotBePrepared) {
  fake.fails_to_prepare = true;
  hello();
  open(1);
  camera(0, 10);
  settle();
  expectError(wire::WireCode::kUnavailable, "view 1: no memory");
  EXPECT_EQ(inbox.back().id, 10U);
}

TEST_F(SessionTest, ReportsACullerThatThrows) {
  fake.on_cull = [] { throw std::runtime_error("out of luck"); };
  hello();
  open(1);
  camera(0, 10);
  settle();
  expectError(wire::WireCode::kInternal, "out of luck");
  fake.on_cull = nullptr;
  camera(0, 11);
  settle();
  EXPECT_EQ(count<wire::Answer>(), 1U);
}

TEST_F(SessionTest, LimitsViews) {
  hello();
  for (std::uint32_t view = 1; view <= 3; ++view) open(view);
  EXPECT_EQ(count<wire::ViewOpened>(), 3U);
  open(4);
  expectError(wire::WireCode::kLimitExceeded, "view 4");
  say(wire::CloseView{2}, 9);
  open(4);
  EXPECT_EQ(count<wire::ViewOpened>(), 4U);
}

TEST_F(SessionTest, SendsNothingMoreOfAClosedView) {
  hello();
  open(1);
  camera(0, 10);
  say(wire::CloseView{1}, 11);
  EXPECT_EQ(count<wire::ViewClosed>(), 1U);
  settle();
  EXPECT_EQ(count<wire::Answer>(), 0U);
  EXPECT_TRUE(session.drained());
}

TEST_F(SessionTest, StartsAViewAnewWhenItIsOpenedAgain) {
  hello();
  open(1);
  camera(0, 10);
  settle();
  camera(1, 11, 1);
  open(1);
  settle();
  EXPECT_EQ(count<wire::Answer>(), 1U) << "the cull of the old view has no one to go to";
  camera(1, 12, 1);
  settle();
  EXPECT_EQ(last<wire::Answer>().frame, 1U);
  EXPECT_EQ(last<wire::Answer>().baseline, 0U);
}

TEST_F(SessionTest, ItsOwnEditIsSeenByTheNextCamera) {
  hello();
  open(1);
  say(wire::Edit{0, {{wire::EditKind::kHide, 3, {}}}}, 10);
  camera(0, 11);
  EXPECT_TRUE(culls.empty()) << "the edit comes first";
  settle();
  EXPECT_EQ(last<wire::Edited>().scene_version, 2U);
  EXPECT_EQ(last<wire::Answer>().scene_version, 2U);
  EXPECT_EQ(last<wire::Answer>().object_count, 99U);
}

TEST_F(SessionTest, RefitsAPreparedMethodOnAnEdit) {
  hello();
  open(1);
  camera(0, 10);
  settle();
  say(wire::Edit{0, {{wire::EditKind::kHide, 3, {}}}}, 11);
  camera(0, 12);
  settle();
  EXPECT_EQ(fake.prepared, 1);
  EXPECT_EQ(fake.refitted, 1);
}

TEST_F(SessionTest, GivesIdsOfAddedObjects) {
  hello();
  wire::EditItem add{wire::EditKind::kAdd, 0, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}};
  say(wire::Edit{0, {add, add}}, 10);
  settle();
  EXPECT_EQ(last<wire::Edited>().added, (std::vector<std::uint32_t>{300, 301}));
}

TEST_F(SessionTest, RefusesBadEdits) {
  hello();
  say(wire::Edit{0, {}}, 10);
  expectError(wire::WireCode::kInvalidEdit, "empty");
  say(wire::Edit{0, {{wire::EditKind::kHide, 300, {}}}}, 11);
  settle();
  expectError(wire::WireCode::kInvalidEdit, "300");
  say(wire::Edit{9, {{wire::EditKind::kHide, 1, {}}}}, 12);
  settle();
  expectError(wire::WireCode::kConflict, "version 1, not 9");
  say(wire::Edit{0, std::vector<wire::EditItem>(5, {wire::EditKind::kHide, 1, {}})}, 13);
  expectError(wire::WireCode::kLimitExceeded, "5 edits > 4");
}

TEST_F(SessionTest, LimitsWaitingEdits) {
  hello();
  for (std::uint64_t id = 10; id < 14; ++id)
    say(wire::Edit{0, {{wire::EditKind::kHide, 1, {}}}}, id);
  expectError(wire::WireCode::kLimitExceeded, "2 are waiting");
  settle();
  EXPECT_EQ(count<wire::Edited>(), 3U);
}

TEST_F(SessionTest, TellsOfTheScenesChangesOncePerUnsentNotice) {
  hello();
  flush();
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(editScene(*scene, {HideObject{static_cast<ObjectId>(i)}}).ok());
    absorb(session.sceneMoved());
  }
  EXPECT_EQ(count<wire::SceneChanged>(), 1U) << "a slow reader is not buried";
  settle();
  EXPECT_EQ(count<wire::SceneChanged>(), 2U);
  EXPECT_EQ(last<wire::SceneChanged>().scene.version, 6U);
}

TEST_F(SessionTest, AnswersFromTheNewSceneAfterItWasReplacedDuringACull) {
  hello();
  open(1);
  camera(0, 10);
  settle();
  camera(0, 11, 1);
  scene->replace(rowOfObjects(30));
  absorb(session.sceneMoved());
  settle();
  EXPECT_TRUE(last<wire::SceneChanged>().replaced);
  const auto& answer = last<wire::Answer>();
  EXPECT_EQ(inbox.back().id, 11U);
  EXPECT_EQ(answer.scene_objects, 30U);
  EXPECT_EQ(answer.object_count, 10U);
  EXPECT_EQ(answer.baseline, 0U);
}

TEST_F(SessionTest, NeverAnswersFromAReplacedSceneBeforeSayingSo) {
  hello();
  open(1);
  scene->replace(rowOfObjects(30));  // and the notice is still on its way to the session
  camera(0, 11);
  settle();
  ASSERT_GE(inbox.size(), 2U);
  EXPECT_TRUE(std::holds_alternative<wire::SceneChanged>(inbox[inbox.size() - 2].body));
  EXPECT_EQ(last<wire::Answer>().scene_objects, 30U);
}

TEST_F(SessionTest, AnswersGarbageWithAnErrorAndLivesOn) {
  hello();
  absorb(session.receive(std::vector<std::uint8_t>(50, 0xEE), clock.time));
  expectError(wire::WireCode::kBadMessage, "CLD1");
  absorb(session.receiveText());
  expectError(wire::WireCode::kBadMessage, "text frame");
  absorb(session.receive(std::vector<std::uint8_t>(limits.max_message_bytes + 1, 1), clock.time));
  expectError(wire::WireCode::kLimitExceeded, "bytes >");
  say(wire::Pong{1}, 8);
  expectError(wire::WireCode::kBadMessage, "only a server sends");
  say(wire::Ping{5}, 9);
  EXPECT_EQ(last<wire::Pong>().time_ns, 5U);
}

TEST_F(SessionTest, FinishesWhatRunsWhenTheServerGoesAway) {
  hello();
  open(1);
  flush();
  camera(0, 10);
  camera(1, 11);
  absorb(session.goAway("maintenance"));
  EXPECT_EQ(last<wire::GoAway>().reason, "maintenance");
  EXPECT_FALSE(session.drained());
  camera(2, 12);
  expectError(wire::WireCode::kUnavailable, "going away");
  settle();
  EXPECT_EQ(inbox.back().id, 11U);
  EXPECT_TRUE(session.drained());
}

}  // namespace
}  // namespace culld::server
