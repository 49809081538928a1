// What a connection does when its server goes and comes back.
#include <gtest/gtest.h>

#include <condition_variable>
#include <future>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "culld/connection.h"
#include "tests/unit/client/scripted_server.h"

namespace culld::client {
namespace {

ConnectOptions again() {
  ConnectOptions options = quick();
  options.reconnect = {true, 10ms, 50ms, 2.0, 0.5, 0};
  return options;
}

/// The states that a connection told, to be waited for.
class States {
 public:
  explicit States(Connection& connection) {
    connection.onState([told = told_](ConnectionState state, const Error& reason) {
      const std::lock_guard lock(told->mutex);
      told->states.push_back(state);
      told->reason = reason;
      told->changed.notify_all();
    });
  }
  bool await(ConnectionState state) {
    std::unique_lock lock(told_->mutex);
    return told_->changed.wait_for(
        lock, 5s, [&] { return !told_->states.empty() && told_->states.back() == state; });
  }
  std::vector<ConnectionState> told() {
    const std::lock_guard lock(told_->mutex);
    return told_->states;
  }
  Error lastReason() {
    const std::lock_guard lock(told_->mutex);
    return told_->reason;
  }

 private:
  struct Told {
    std::mutex mutex;
    std::condition_variable changed;
    std::vector<ConnectionState> states;
    Error reason;
  };
  std::shared_ptr<Told> told_ = std::make_shared<Told>();  ///< outlived by the connection
};

/// One view answered, then death.
void liveAndDie(Peer& peer) {
  peer.greet();
  peer.openView();
  peer.send({peer.nextCamera().first, wholeAnswer(1, {1, 2})});
  peer.cut();
}

TEST(Reconnect, OpensViewsUnderTheSameNumberAndAsksTheirLastCameraAgain) {
  std::promise<void> cut;
  Script server({[&](Peer& peer) {
                   liveAndDie(peer);
                   cut.set_value();
                 },
                 [](Peer& peer) {
                   peer.greet();
                   EXPECT_EQ(peer.openView(), (protocol::OpenView{1, "frustum", true}));
                   const auto [id, update] = peer.nextCamera();
                   EXPECT_EQ(update.view, 1U);
                   EXPECT_EQ(update.ack_frame, 0U);
                   EXPECT_EQ(update.camera.width_px, 77U);
                   peer.send({id, wholeAnswer(1, {3})});
                   const auto next = peer.nextCamera();
                   EXPECT_EQ(next.second.ack_frame, 1U);
                   peer.send({next.first, changedAnswer(2, {3, 4}, 1, {3})});
                   peer.awaitEnd();
                 }});
  std::promise<FramePtr> restarted;
  std::uint32_t frames = 0;
  auto connection = Connection::open(server.address(), "town", again());
  ASSERT_TRUE(connection.ok()) << connection.error().message;
  States states(*connection.value());
  auto view = connection.value()->openView("frustum", true);
  ASSERT_TRUE(view.ok()) << view.error().message;
  view.value().onFrame([&](const FramePtr& frame) {
    if (++frames == 2) restarted.set_value(frame);
  });
  Camera camera;
  camera.width_px = 77;
  EXPECT_EQ(view.value().cull(camera).value()->visible, (Ids{1, 2}));
  auto frame = restarted.get_future();
  ASSERT_EQ(frame.wait_for(5s), std::future_status::ready);
  const FramePtr whole = frame.get();
  EXPECT_EQ(whole->visible, Ids{3});
  EXPECT_FALSE(whole->delta);
  EXPECT_EQ(whole->camera, 1U);
  const auto next = view.value().cull(camera);
  ASSERT_TRUE(next.ok()) << next.error().message;
  EXPECT_EQ(next.value()->visible, (Ids{3, 4}));
  EXPECT_EQ(next.value()->camera, 2U);
  ASSERT_TRUE(states.await(ConnectionState::kConnected));
  EXPECT_EQ(states.told(), (std::vector<ConnectionState>{ConnectionState::kReconnecting,
                                                         ConnectionState::kConnected}));
}

TEST(Reconnect, AnswersACameraThatWasUnderWay) {
  Script server({[](Peer& peer) {
                   peer.greet();
                   peer.openView();
                   peer.nextCamera();
                   peer.cut();
                 },
                 [](Peer& peer) {
                   peer.greet();
                   peer.openView();
                   peer.send({peer.nextCamera().first, wholeAnswer(1, {9})});
                   peer.awaitEnd();
                 }});
  const Client client(server.address(), again());
  ASSERT_NE(client.view, nullptr);
  const auto frame = client.view->cull({});
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame.value()->visible, Ids{9});
}

TEST(Refusal, OfACameraThatStandsForOlderOnesIsTheirs) {
  using protocol::WireCode;
  for (const bool on_arrival : {false, true}) {
    Script server([on_arrival](Peer& peer) {
      peer.greet();
      peer.openView();
      const auto first = peer.nextCamera().first;
      const auto second = peer.nextCamera().first;
      const auto code = on_arrival ? WireCode::kInvalidCamera : WireCode::kInternal;
      peer.send({second, protocol::ErrorReply{code, "no"}});
      if (on_arrival) peer.send({first, wholeAnswer(1, {4})});
      peer.awaitEnd();
    });
    const Client client(server.address());
    ASSERT_NE(client.view, nullptr);
    auto older = client.view->setCamera({});
    auto newer = client.view->setCamera({});
    ASSERT_EQ(newer.wait_for(5s), std::future_status::ready);
    EXPECT_FALSE(newer.get().ok());
    ASSERT_EQ(older.wait_for(5s), std::future_status::ready) << "told of nothing";
    EXPECT_EQ(older.get().ok(), on_arrival);
  }
}

TEST(Refusal, OfACameraAskedAgainIsAlsoThatOfThoseItStandsFor) {
  Script server({[](Peer& peer) {
                   peer.greet();
                   peer.openView();
                   peer.nextCamera();
                   peer.nextCamera();
                   peer.cut();
                 },
                 [](Peer& peer) {
                   peer.greet();
                   peer.openView();
                   peer.send({peer.nextCamera().first,
                              protocol::ErrorReply{protocol::WireCode::kQuotaExceeded, "spent"}});
                   peer.awaitEnd();
                 }});
  const Client client(server.address(), again());
  ASSERT_NE(client.view, nullptr);
  auto older = client.view->setCamera({});
  auto newer = client.view->setCamera({});
  for (auto* waiting : {&older, &newer}) {
    ASSERT_EQ(waiting->wait_for(5s), std::future_status::ready);
    EXPECT_FALSE(waiting->get().ok());
  }
}

TEST(Misfit, OfWhatWasUnderWayDoesNotEndTheWaitForTheWhole) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    const auto first = peer.nextCamera().first;
    const auto second = peer.nextCamera().first;
    Answer wrong = wholeAnswer(1, {1});
    wrong.set_hash ^= 1;
    peer.send({first, wrong});
    wrong.frame = 2;
    peer.send({second, wrong});  // left before the client could ask for a whole one
    peer.send({peer.nextCamera().first, wholeAnswer(3, {5})});
    peer.awaitEnd();
  });
  const Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  auto older = client.view->setCamera({});
  auto newer = client.view->setCamera({});
  for (auto* waiting : {&older, &newer}) {
    ASSERT_EQ(waiting->wait_for(5s), std::future_status::ready);
    const auto frame = waiting->get();
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_EQ(frame.value()->visible, Ids{5});
  }
  EXPECT_EQ(client.view->misfits(), 1U);
}

TEST(Reconnect, KeepsCamerasOfTheTimeBetween) {
  std::promise<void> asked;
  auto was_asked = asked.get_future();
  Script server({liveAndDie, [&](Peer& peer) {
                   was_asked.wait();
                   peer.greet();
                   peer.openView();
                   const auto [id, update] = peer.nextCamera();
                   EXPECT_EQ(update.camera.width_px, 3U);  // the newest only
                   peer.send({id, wholeAnswer(1, {5})});
                   peer.awaitEnd();
                 }});
  const Client client(server.address(), again());
  ASSERT_NE(client.view, nullptr);
  States states(*client.connection);
  ASSERT_TRUE(client.view->cull({}).ok());
  ASSERT_TRUE(states.await(ConnectionState::kReconnecting));
  std::vector<std::future<Result<FramePtr>>> waiting;
  for (std::uint32_t width : {1U, 2U, 3U}) {
    Camera camera;
    camera.width_px = width;
    waiting.push_back(client.view->setCamera(camera));
  }
  const auto pong = client.connection->ping();
  ASSERT_FALSE(pong.ok());
  EXPECT_EQ(pong.error().message, toString(server.address()) + ": not connected");
  asked.set_value();
  for (auto& future : waiting) {
    ASSERT_EQ(future.wait_for(5s), std::future_status::ready);
    const auto frame = future.get();
    ASSERT_TRUE(frame.ok()) << frame.error().message;
    EXPECT_EQ(frame.value()->visible, Ids{5});
    EXPECT_EQ(frame.value()->camera, 4U);
  }
}

TEST(Reconnect, DoesNotLetCamerasPileUp) {
  std::promise<void> done;
  auto may_end = done.get_future();
  Script server({liveAndDie, [&](Peer&) { may_end.wait(); }});
  const Client client(server.address(), again());
  ASSERT_NE(client.view, nullptr);
  States states(*client.connection);
  ASSERT_TRUE(client.view->cull({}).ok());
  ASSERT_TRUE(states.await(ConnectionState::kReconnecting));
  auto oldest = client.view->setCamera({});
  for (int i = 0; i < 1100; ++i) client.view->setCamera({}, {}, [](const Result<FramePtr>&) {});
  ASSERT_EQ(oldest.wait_for(5s), std::future_status::ready);
  EXPECT_EQ(oldest.get().error().message,
            toString(server.address()) + ": too many newer cameras wait");
  done.set_value();
}

TEST(Reconnect, FailsAnEditThatWasUnderWayAsNobodyKnowsWhetherItHappened) {
  Script server({[](Peer& peer) {
                   peer.greet();
                   peer.openView();
                   peer.next();
                   peer.cut();
                 },
                 [](Peer& peer) {
                   peer.greet();
                   peer.openView();
                   const Message message = peer.next();  // not the edit again
                   EXPECT_TRUE(std::holds_alternative<protocol::Ping>(message.body));
                   peer.send({message.id, protocol::Pong{1}});
                   peer.awaitEnd();
                 }});
  const Client client(server.address(), again());
  ASSERT_NE(client.view, nullptr);
  States states(*client.connection);
  const auto edited = client.connection->edit({{protocol::EditKind::kHide, 1, {}}});
  ASSERT_FALSE(edited.ok());
  EXPECT_EQ(edited.error().code, ErrorCode::kUnavailable);
  EXPECT_NE(edited.error().message.find("connection lost"), std::string::npos)
      << edited.error().message;
  ASSERT_TRUE(states.await(ConnectionState::kConnected));
  EXPECT_TRUE(client.connection->ping().ok());
}

TEST(Reconnect, TellsThatTheSceneIsAnotherOne) {
  Script server({liveAndDie, [](Peer& peer) {
                   peer.greet(5);
                   peer.awaitEnd();
                 }});
  std::promise<std::pair<SceneInfo, bool>> changed;
  const Client client(server.address(), again());
  ASSERT_NE(client.view, nullptr);
  client.connection->onSceneChanged([&](const SceneInfo& scene, bool replaced) {
    changed.set_value({scene, replaced});
  });
  ASSERT_TRUE(client.view->cull({}).ok());
  auto told = changed.get_future();
  ASSERT_EQ(told.wait_for(5s), std::future_status::ready);
  const auto [scene, replaced] = told.get();
  EXPECT_EQ(scene.version, 5U);
  EXPECT_TRUE(replaced);
  EXPECT_EQ(client.connection->scene().version, 5U);
}

TEST(Reconnect, AsksAgainWhatAServerRefusedOnItsWayOut) {
  Script server({[](Peer& peer) {
                   peer.greet();
                   peer.openView();
                   peer.send({0, protocol::GoAway{"shutting down"}});
                   peer.send({peer.nextCamera().first,
                              protocol::ErrorReply{protocol::WireCode::kUnavailable, "going"}});
                   peer.cut();
                 },
                 [](Peer& peer) {
                   peer.greet();
                   peer.openView();
                   peer.send({peer.nextCamera().first, wholeAnswer(1, {6})});
                   peer.awaitEnd();
                 }});
  const Client client(server.address(), again());
  ASSERT_NE(client.view, nullptr);
  const auto frame = client.view->cull({});
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame.value()->visible, Ids{6});
}

TEST(Reconnect, EndsAViewThatCannotBeOpenedAgain) {
  Script server({[](Peer& peer) {
                   peer.greet();
                   peer.openView();
                   peer.nextCamera();
                   peer.cut();
                 },
                 [](Peer& peer) {
                   peer.greet();
                   peer.send(
                       {peer.next().id,
                        protocol::ErrorReply{protocol::WireCode::kUnknownMethod, "no raster"}});
                   peer.awaitEnd();
                 }});
  const Client client(server.address(), again());
  ASSERT_NE(client.view, nullptr);
  const auto frame = client.view->cull({});
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(client.view->setCamera({}).get().error().message, "no raster");
}

TEST(Reconnect, EndsWhenTheServerSaysThatItsSceneIsGone) {
  Script server({liveAndDie, [](Peer& peer) {
                   peer.refuse(404, R"({"error":"scene \"town\" is not known"})");
                 }});
  const Client client(server.address(), again());
  ASSERT_NE(client.view, nullptr);
  States states(*client.connection);
  ASSERT_TRUE(client.view->cull({}).ok());
  ASSERT_TRUE(states.await(ConnectionState::kEnded));
  EXPECT_EQ(states.lastReason().code, ErrorCode::kNotFound);
  EXPECT_EQ(client.view->cull({}).error().message, "scene \"town\" is not known");
  EXPECT_EQ(client.connection->state(), ConnectionState::kEnded);
}

TEST(Reconnect, TriesOnWhileTheServerIsBusyOrMute) {
  std::promise<void> done;
  auto may_end = done.get_future();
  ConnectOptions options = again();
  options.timeouts.connect = 200ms;
  Script server({liveAndDie, [](Peer& peer) { peer.refuse(503, R"({"error":"still loading"})"); },
                 [](Peer& peer) {  // takes the Hello and says nothing
                   peer.accept();
                   peer.awaitEnd();
                 },
                 [](Peer& peer) { peer.cut(); },
                 [&](Peer& peer) {
                   peer.greet();
                   peer.openView();
                   peer.send({peer.nextCamera().first, wholeAnswer(1, {8})});
                   may_end.wait();
                 }});
  std::promise<void> back;
  const Client client(server.address(), options);
  ASSERT_NE(client.view, nullptr);
  client.view->onFrame([&](const FramePtr& frame) {
    if (frame->visible == Ids{8}) back.set_value();
  });
  ASSERT_TRUE(client.view->cull({}).ok());
  EXPECT_EQ(back.get_future().wait_for(5s), std::future_status::ready);
  done.set_value();
}

TEST(Reconnect, GivesUpAfterTheAttemptsAllowed) {
  ConnectOptions options = again();
  options.reconnect.max_attempts = 2;
  Script server({liveAndDie, [](Peer& peer) { peer.cut(); }, [](Peer& peer) { peer.cut(); }});
  const Client client(server.address(), options);
  ASSERT_NE(client.view, nullptr);
  States states(*client.connection);
  ASSERT_TRUE(client.view->cull({}).ok());
  ASSERT_TRUE(states.await(ConnectionState::kEnded));
  EXPECT_FALSE(client.view->cull({}).ok());
}

}  // namespace
}  // namespace culld::client
