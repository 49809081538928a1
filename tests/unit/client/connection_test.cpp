// The SDK against a scripted server: what a real one does only on a bad day.
#include "culld/connection.h"

#include <gtest/gtest.h>

#include <future>
#include <string>
#include <utility>
#include <vector>

#include "culld/scenes.h"
#include "tests/unit/client/scripted_server.h"

namespace culld::client {
namespace {

TEST(Connection, LearnsTheSceneFromTheWelcome) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    peer.awaitEnd();
  });
  const Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  EXPECT_EQ(client.connection->scene().name, "town");
  EXPECT_EQ(client.connection->scene().objects, 1000U);
  EXPECT_EQ(client.view->method(), "raster");
}

TEST(View, AppliesChangesAndAcknowledgesWhatItHolds) {
  const Ids first{1, 2, 3}, second{2, 3, 500};
  Script server([&](Peer& peer) {
    peer.greet();
    peer.openView();
    auto [id, update] = peer.nextCamera();
    EXPECT_EQ(update.ack_frame, 0U);
    peer.send({id, wholeAnswer(1, first)});
    std::tie(id, update) = peer.nextCamera();
    EXPECT_EQ(update.ack_frame, 1U);
    peer.send({id, changedAnswer(2, second, 1, first)});
    peer.awaitEnd();
  });
  const Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  EXPECT_EQ(client.view->newest(), nullptr);
  ASSERT_EQ(client.view->cull({}).value()->visible, first);
  const auto frame = client.view->cull({});
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame.value()->visible, second);
  EXPECT_TRUE(frame.value()->delta);
  EXPECT_EQ(client.view->newest(), frame.value());
}

TEST(View, AsksForAWholeAnswerWhenTheHashDiffers) {
  const Ids ids{4, 5};
  Script server([&](Peer& peer) {
    peer.greet();
    peer.openView();
    auto [id, update] = peer.nextCamera();
    peer.send({id, wholeAnswer(1, {1})});
    std::tie(id, update) = peer.nextCamera();
    EXPECT_EQ(update.ack_frame, 1U);
    Answer wrong = wholeAnswer(2, ids);
    wrong.set_hash ^= 1U;
    peer.send({id, wrong});
    std::tie(id, update) = peer.nextCamera();
    EXPECT_EQ(update.ack_frame, 0U);
    EXPECT_EQ(update.camera.width_px, 99U);
    peer.send({id, wholeAnswer(3, ids)});
    peer.awaitEnd();
  });
  const Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  ASSERT_TRUE(client.view->cull({}).ok());
  Camera camera;
  camera.width_px = 99;
  const auto frame = client.view->cull(camera);
  ASSERT_TRUE(frame.ok()) << frame.error().message;
  EXPECT_EQ(frame.value()->visible, ids);
  EXPECT_EQ(frame.value()->number, 3U);
}

TEST(View, GivesUpOnAServerWhoseSetsNeverFit) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    for (std::uint32_t frame = 1; frame <= 2; ++frame) {
      Answer wrong = wholeAnswer(frame, {1});
      ++wrong.object_count;
      peer.send({peer.nextCamera().first, wrong});
    }
    peer.awaitEnd();
  });
  const Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  const auto frame = client.view->cull({});
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().message, "view 1: frame 2: has a wrong count");
}

TEST(View, GivesTheNewestAnswerToCamerasThatWerePassedOver) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    peer.nextCamera();
    peer.nextCamera();
    peer.send({peer.nextCamera().first, wholeAnswer(1, {8})});
    peer.awaitEnd();
  });
  const Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  std::vector<std::future<Result<FramePtr>>> futures;
  for (int i = 0; i < 3; ++i) futures.push_back(client.view->setCamera({}));
  for (auto& future : futures) {
    ASSERT_EQ(future.wait_for(5s), std::future_status::ready);
    EXPECT_EQ(future.get().value()->visible, Ids{8});
  }
}

TEST(View, KeepsTheFrameThatACameraUnderWayHasAcknowledged) {
  const Ids a{1}, b{2}, c{3};
  Script server([&](Peer& peer) {
    peer.greet();
    peer.openView();
    peer.send({peer.nextCamera().first, wholeAnswer(1, a)});
    const auto second = peer.nextCamera();
    const auto third = peer.nextCamera();
    EXPECT_EQ(third.second.ack_frame, 1U);
    peer.send({second.first, changedAnswer(2, b, 1, a)});
    peer.send({third.first, changedAnswer(3, c, 1, a)});
    peer.awaitEnd();
  });
  const Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  ASSERT_TRUE(client.view->cull({}).ok());
  auto second = client.view->setCamera({});
  auto third = client.view->setCamera({});
  EXPECT_EQ(second.get().value()->visible, b);
  EXPECT_EQ(third.get().value()->visible, c);
}

TEST(View, CallsBackForEveryFrame) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    for (std::uint32_t frame = 1; frame <= 3; ++frame) {
      peer.send({peer.nextCamera().first, wholeAnswer(frame, {frame})});
    }
    peer.awaitEnd();
  });
  std::vector<std::uint32_t> numbers;
  std::promise<void> third;
  const Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  client.view->onFrame([&](const FramePtr& frame) {
    numbers.push_back(frame->number);
    if (frame->number == 3) third.set_value();
  });
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(client.view->cull({}).ok());
  ASSERT_EQ(third.get_future().wait_for(5s), std::future_status::ready);
  EXPECT_EQ(numbers, (std::vector<std::uint32_t>{1, 2, 3}));
}

TEST(View, PassesOnWhatTheServerSaysAboutACamera) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    peer.send({peer.nextCamera().first,
               protocol::ErrorReply{protocol::WireCode::kInvalidCamera, "view 1: eye is NaN"}});
    peer.send({peer.nextCamera().first, wholeAnswer(1, {1})});
    peer.awaitEnd();
  });
  const Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  const auto refused = client.view->cull({});
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kInvalidInput);
  EXPECT_EQ(refused.error().message, "view 1: eye is NaN");
  EXPECT_TRUE(client.view->cull({}).ok());
}

TEST(View, DoesNotReferToFramesOfAReplacedScene) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    peer.send({peer.nextCamera().first, wholeAnswer(1, {1})});
    peer.send({0, protocol::SceneChanged{{"town", 1, 8, 5, 50}, true}});
    const auto [id, update] = peer.nextCamera();
    EXPECT_EQ(update.ack_frame, 0U);
    peer.send({id, wholeAnswer(2, {2})});
    peer.awaitEnd();
  });
  std::promise<SceneInfo> changed;
  const Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  client.connection->onSceneChanged([&](const SceneInfo& scene, bool replaced) {
    EXPECT_TRUE(replaced);
    changed.set_value(scene);
  });
  ASSERT_TRUE(client.view->cull({}).ok());
  auto scene = changed.get_future();
  ASSERT_EQ(scene.wait_for(5s), std::future_status::ready);
  EXPECT_EQ(scene.get().objects, 5U);
  EXPECT_EQ(client.connection->scene().objects, 5U);
  EXPECT_TRUE(client.view->cull({}).ok());
}

TEST(Connection, EndsEveryWaitWhenItIsLost) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    peer.nextCamera();
    peer.send({0, protocol::GoAway{"maintenance"}});
  });
  const Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  const auto frame = client.view->cull({});
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(frame.error().message, toString(server.address()) + ": server went away: maintenance");
  EXPECT_EQ(client.view->setCamera({}).get().error().message, frame.error().message);
  EXPECT_EQ(client.connection->ping().error().message, frame.error().message);
}

TEST(Connection, ClosesAtOnceAfterItWasLost) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    peer.nextCamera();
  });
  const auto start = std::chrono::steady_clock::now();
  {
    const Client client(server.address());
    ASSERT_NE(client.view, nullptr);
    EXPECT_FALSE(client.view->cull({}).ok());
  }
  EXPECT_LT(std::chrono::steady_clock::now() - start, 2s);  // the idle timer runs for 10 s
}

TEST(Connection, EndsOnGarbage) {
  Script server([](Peer& peer) {
    peer.greet();
    peer.openView();
    peer.nextCamera();
    peer.sendBytes({1, 2, 3, 4, 5});
    peer.awaitEnd();
  });
  Client client(server.address());
  ASSERT_NE(client.view, nullptr);
  const auto frame = client.view->cull({});
  ASSERT_FALSE(frame.ok());
  EXPECT_NE(frame.error().message.find("malformed message"), std::string::npos)
      << frame.error().message;
}

TEST(Connection, DoesNotWaitForeverForASilentServer) {
  Script silent([](Peer& peer) {
    peer.greet();
    peer.openView();
    peer.nextCamera();
    peer.awaitEnd();
  });
  ConnectOptions options = quick();
  options.timeouts.reply = 100ms;
  auto connection = Connection::open(silent.address(), "town", options);
  ASSERT_TRUE(connection.ok()) << connection.error().message;
  auto view = connection.value()->openView();
  ASSERT_TRUE(view.ok());
  const auto frame = view.value().cull({});
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().message, toString(silent.address()) + ": no answer within 100 ms");
}

TEST(Connection, DoesNotWaitForeverForAHandshake) {
  std::promise<void> done;
  Script mute([&](Peer&) { done.get_future().wait(); });
  ConnectOptions options = quick();
  options.timeouts.connect = 100ms;
  const auto connection = Connection::open(mute.address(), "town", options);
  done.set_value();
  ASSERT_FALSE(connection.ok());
  EXPECT_EQ(connection.error().code, ErrorCode::kUnavailable);
}

TEST(Connection, PassesOnThatVersionsDoNotMeet) {
  Script server([](Peer& peer) {
    peer.accept();
    peer.send({peer.next().id, protocol::ErrorReply{protocol::WireCode::kUnsupportedVersion,
                                                    "protocol 1 to 1 asked for"}});
    peer.awaitEnd();
  });
  const auto connection = Connection::open(server.address(), "town", quick());
  ASSERT_FALSE(connection.ok());
  EXPECT_EQ(connection.error().code, ErrorCode::kUnsupported);
  EXPECT_EQ(connection.error().message, "protocol 1 to 1 asked for");
}

TEST(Connection, PassesOnARefusalAtOnce) {
  Script server([](Peer& peer) {
    peer.refuse(404, R"({"error":"scene \"town\" is not known"})");
    peer.awaitEnd();
  });
  const auto start = std::chrono::steady_clock::now();
  ConnectOptions options = quick();
  options.timeouts.connect = 5000ms;
  const auto connection = Connection::open(server.address(), "town", options);
  EXPECT_LT(std::chrono::steady_clock::now() - start, 3s);  // the handshake's limit is 5 s
  ASSERT_FALSE(connection.ok());
  EXPECT_EQ(connection.error().code, ErrorCode::kNotFound);
  EXPECT_EQ(connection.error().message, "scene \"town\" is not known");
}

TEST(Connection, SaysWhoCannotBeReached) {
  boost::asio::io_context io;
  tcp::acceptor acceptor(io, tcp::endpoint(tcp::v4(), 0));
  const Address address{"127.0.0.1", acceptor.local_endpoint().port(), {}};
  acceptor.close();
  const auto connection = Connection::open(address, "town", quick());
  ASSERT_FALSE(connection.ok());
  EXPECT_EQ(connection.error().message, toString(address) + ": cannot connect: Connection refused");
  const auto absent = Scenes(Address{{}, 0, "/nonexistent/socket"}).list();
  ASSERT_FALSE(absent.ok());
  EXPECT_EQ(absent.error().code, ErrorCode::kUnavailable);
  EXPECT_EQ(absent.error().message,
            "unix:/nonexistent/socket: cannot connect: No such file or directory");
}

}  // namespace
}  // namespace culld::client
