// Sessions over real sockets: views, newest camera wins, changes, edits, bad input, rude clients.
#include <gtest/gtest.h>

#include <thread>

#include "protocol/codec.h"
#include "protocol/id_set.h"
#include "tests/integration/gate.h"
#include "tests/integration/server_fixture.h"

namespace culld::testing {
namespace {

namespace wire = protocol;

class Live : public ServerTest {
 protected:
  LiveClient connect() {
    LiveClient client(socket(), "row");
    EXPECT_EQ(client.upgradeStatus(), 101);
    EXPECT_TRUE(client.hello().has_value());
    return client;
  }
  std::vector<ObjectId> expected(std::uint32_t objects, double x) const {
    return server::fakeVisible(*server::rowOfObjects(objects), x);
  }
};

TEST_F(Live, AnswersCamerasOfSeveralViewsOfSeveralClients) {
  startWithRow();
  LiveClient a = connect();
  LiveClient b = connect();
  for (LiveClient* client : {&a, &b}) {
    ASSERT_TRUE(client->openView(1));
    ASSERT_TRUE(client->openView(7));
  }
  for (LiveClient* client : {&a, &b}) {
    for (const std::uint32_t view : {1U, 7U}) {
      client->send(cameraAt(view, 0, view), 100 + view);
      std::uint64_t id = 0;
      const auto answer = client->await<wire::Answer>(&id);
      ASSERT_TRUE(answer);
      EXPECT_EQ(id, 100 + view);
      EXPECT_EQ(answer->view, view);
      const auto set = wire::decodeSet(answer->encoding, answer->payload, answer->scene_objects);
      ASSERT_TRUE(set.ok());
      EXPECT_EQ(set.value(), expected(300, view));
    }
  }
}

TEST_F(Live, WorksTheSameOnTheUnixSocket) {
  options.unix_path = (folder / "sock").string();
  startWithRow();
  LiveClient client(RawSocket::unixDomain(options.unix_path), "row");
  ASSERT_EQ(client.upgradeStatus(), 101);
  ASSERT_TRUE(client.hello());
  ASSERT_TRUE(client.openView(1));
  client.send(cameraAt(2));
  const auto answer = client.await<wire::Answer>();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->set_hash, wire::setHash(expected(300, 2)));
}

TEST_F(Live, NewestCameraWins) {
  Gate gate;
  fake.on_cull = [&gate] { gate.pass(); };
  startWithRow();
  LiveClient client = connect();
  ASSERT_TRUE(client.openView(1));
  client.send(cameraAt(0), 10);
  gate.awaitArrival();
  for (std::uint64_t id = 11; id <= 30; ++id) client.send(cameraAt(static_cast<double>(id)), id);
  client.send(wire::Ping{1}, 99);
  ASSERT_TRUE(client.await<wire::Pong>()) << "a running cull does not stop the conversation";
  gate.open();
  std::uint64_t id = 0;
  ASSERT_TRUE(client.await<wire::Answer>(&id));
  EXPECT_EQ(id, 10U);
  const auto newest = client.await<wire::Answer>(&id);
  ASSERT_TRUE(newest);
  EXPECT_EQ(id, 30U);
  EXPECT_EQ(newest->superseded, 19U);
  EXPECT_EQ(newest->set_hash, wire::setHash(expected(300, 30)));
}

TEST_F(Live, ChangesAddUpToFullSets) {
  startWithRow(5000);
  LiveClient client = connect();
  ASSERT_TRUE(client.openView(1));
  std::map<std::uint32_t, wire::IdSet> held;
  std::uint32_t ack = 0;
  std::size_t changes = 0;
  for (int i = 0; i < 40; ++i) {
    const double x = (i / 4) % 3;
    client.send(cameraAt(x, ack));
    const auto answer = client.await<wire::Answer>();
    ASSERT_TRUE(answer);
    const auto set = wire::decodeSet(answer->encoding, answer->payload, answer->scene_objects,
                                     held[answer->baseline]);
    ASSERT_TRUE(set.ok()) << set.error().message;
    EXPECT_EQ(set.value(), expected(5000, x));
    EXPECT_EQ(answer->set_hash, wire::setHash(set.value()));
    EXPECT_EQ(answer->object_count, set.value().size());
    held[answer->frame] = set.value();
    ack = answer->frame;
    changes += answer->baseline != 0 ? 1U : 0U;
  }
  EXPECT_GE(changes, 25U);
}

TEST_F(Live, AnEditOfOneClientIsInTheNextAnswerOfAll) {
  startWithRow();
  LiveClient a = connect();
  LiveClient b = connect();
  ASSERT_TRUE(a.openView(1));
  ASSERT_TRUE(b.openView(1));
  a.send(wire::Edit{0, {{wire::EditKind::kHide, 3, {}}, {wire::EditKind::kRemove, 6, {}}}}, 5);
  const auto edited = a.await<wire::Edited>();
  ASSERT_TRUE(edited);
  EXPECT_EQ(edited->scene_version, 2U);
  for (LiveClient* client : {&a, &b}) {
    client->send(cameraAt(0));
    const auto answer = client->await<wire::Answer>();
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->scene_version, 2U);
    EXPECT_EQ(answer->object_count, 98U);
  }
  LiveClient late = connect();
  late.send(wire::Ping{1});
  b.send(wire::Edit{0, {{wire::EditKind::kShow, 3, {}}}}, 6);
  const auto notice = a.await<wire::SceneChanged>();
  ASSERT_TRUE(notice);
  EXPECT_FALSE(notice->replaced);
}

TEST_F(Live, ReplacingASceneVoidsIdsAndSaysSo) {
  startWithRow(300);
  LiveClient client = connect();
  ASSERT_TRUE(client.openView(1));
  client.send(cameraAt(0));
  ASSERT_TRUE(client.await<wire::Answer>());
  EXPECT_EQ(request(port(), "PUT", "/v1/scenes/row", rowGlb(30)).status, 200);
  const auto notice = client.await<wire::SceneChanged>();
  ASSERT_TRUE(notice);
  EXPECT_TRUE(notice->replaced);
  EXPECT_EQ(notice->scene.objects, 30U);
  client.send(cameraAt(0, 1));
  const auto answer = client.await<wire::Answer>();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->baseline, 0U);
  EXPECT_EQ(answer->object_count, 10U);
}

TEST_F(Live, RemovingASceneSendsItsClientsAway) {
  startWithRow();
  LiveClient client = connect();
  EXPECT_EQ(request(port(), "DELETE", "/v1/scenes/row").status, 204);
  const auto going = client.await<wire::GoAway>();
  ASSERT_TRUE(going);
  EXPECT_NE(going->reason.find("row"), std::string::npos);
  const auto frame = client.receiveFrame();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->opcode, 8U);
  EXPECT_EQ(frame->closeCode(), 1001U);
}

TEST_F(Live, NamesBadInputAndLivesOn) {
  startWithRow();
  LiveClient client = connect();
  ASSERT_TRUE(client.openView(1));
  const auto error = [&client] {
    const auto reply = client.await<wire::ErrorReply>();
    return reply ? wire::wireCodeName(reply->code) + ": " + reply->message : "none";
  };
  client.send(cameraAt(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(error().rfind("invalid-camera: view 1: ", 0), 0U);
  wire::CameraUpdate singular;
  singular.view = 1;
  singular.camera.pose = wire::Matrices{};
  client.send(singular);
  EXPECT_EQ(error().rfind("invalid-camera: view 1: ", 0), 0U);
  wire::CameraUpdate empty = cameraAt(0);
  empty.camera.width_px = 0;
  client.send(empty);
  EXPECT_EQ(error().rfind("invalid-camera: view 1: ", 0), 0U);
  client.send(wire::OpenView{2, "magic", false});
  EXPECT_EQ(error(), "unknown-method: view 2: method \"magic\" is not known");
  client.send(cameraAt(0, 0, 5));
  EXPECT_EQ(error(), "unknown-view: view 5 is not open");
  client.send(wire::Hello{3, 4, "late"});
  EXPECT_EQ(error().rfind("bad-message: ", 0), 0U);
  client.sendFrame(1, "hello?");
  EXPECT_EQ(error(), "bad-message: text frame where a binary message is due");
  client.sendFrame(2, std::string(64, '\xEE'));
  EXPECT_EQ(error().rfind("bad-message: ", 0), 0U);
  client.sendFrame(2, "");
  EXPECT_EQ(error().rfind("bad-message: ", 0), 0U);
  client.send(cameraAt(1), 77);
  std::uint64_t id = 0;
  ASSERT_TRUE(client.await<wire::Answer>(&id));
  EXPECT_EQ(id, 77U);
}

TEST_F(Live, ErrorsAreOneLineWhateverTheyName) {
  startWithRow();
  LiveClient client = connect();
  client.send(wire::OpenView{2, "x\ny\x1b[31m", false});
  const auto reply = client.await<wire::ErrorReply>();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->message, "view 2: method \"x\\ny\\x1b[31m\" is not known");
}

TEST_F(Live, NamesAVersionThatIsNotSpokenHere) {
  startWithRow();
  LiveClient client(socket(), "row");
  client.send(wire::Hello{7, 9, "future"});
  const auto reply = client.await<wire::ErrorReply>();
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->code, wire::WireCode::kUnsupportedVersion);
  EXPECT_TRUE(client.hello()) << "and a fitting one is still welcome";
}

TEST_F(Live, RefusesUpgradesWithAStatus) {
  startWithRow();
  EXPECT_EQ(LiveClient(socket(), "nowhere").upgradeStatus(), 404);
  EXPECT_EQ(LiveClient(socket(), "row", "").upgradeStatus(), 400);
  EXPECT_EQ(LiveClient(socket(), "row", "culld.v99").upgradeStatus(), 400);
  LiveClient several(socket(), "row", "chat, culld.v1");
  EXPECT_EQ(several.upgradeStatus(), 101);
  EXPECT_NE(several.upgradeHeader().find("Sec-WebSocket-Protocol: culld.v1\r\n"),
            std::string::npos);
}

TEST_F(Live, TakesMessagesInPieces) {
  startWithRow();
  LiveClient client = connect();
  const auto ping = wire::encode({3, wire::Ping{42}});
  const std::string bytes(ping.begin(), ping.end());
  client.sendFrame(2, bytes.substr(0, 10), false);
  client.sendFrame(9, "are you there");  // a control frame may come in between
  client.sendFrame(0, bytes.substr(10), true);
  const auto pong_frame = client.receiveFrame();
  ASSERT_TRUE(pong_frame);
  EXPECT_EQ(pong_frame->opcode, 10U);
  EXPECT_EQ(pong_frame->payload, "are you there");
  const auto pong = client.await<wire::Pong>();
  ASSERT_TRUE(pong);
  EXPECT_EQ(pong->time_ns, 42U);
}

TEST_F(Live, ClosesOnWhatWebSocketForbids) {
  startWithRow();
  const auto closeCodeAfter = [this](auto misbehave) {
    LiveClient client = connect();
    misbehave(client);
    const auto frame = client.receiveFrame();
    return frame && frame->opcode == 8 ? frame->closeCode() : 0U;
  };
  EXPECT_EQ(closeCodeAfter([](LiveClient& c) { c.sendFrame(2, "x", true, false); }), 1002U)
      << "unmasked";
  EXPECT_EQ(closeCodeAfter([](LiveClient& c) { c.sendFrame(3, "x"); }), 1002U) << "reserved opcode";
  EXPECT_EQ(closeCodeAfter([](LiveClient& c) { c.sendFrame(0, "x"); }), 1002U) << "no beginning";
  EXPECT_EQ(closeCodeAfter([](LiveClient& c) { c.sendFrame(9, std::string(126, 'x')); }), 1002U)
      << "long ping";
  EXPECT_EQ(closeCodeAfter([this](LiveClient& c) {
              c.sendFrame(2, std::string(options.limits.session.max_message_bytes + 1, 'x'));
            }),
            1009U)
      << "too long a message";
  EXPECT_EQ(closeCodeAfter([](LiveClient& c) { c.sendFrame(1, "\xC3\x28"); }), 1007U)
      << "text that is no UTF-8";
}

TEST_F(Live, ClosesWithoutHelloInTime) {
  options.limits.session.hello_timeout = std::chrono::milliseconds(200);
  startWithRow();
  LiveClient client(socket(), "row");
  const auto frame = client.receiveFrame();
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->closeCode(), 1008U);
}

TEST_F(Live, ASilentConnectionEndsAfterTheIdleTimeout) {
  options.limits.session.idle_timeout = std::chrono::milliseconds(400);
  startWithRow();
  LiveClient client = connect();
  EXPECT_TRUE(client.socket().readToEnd()) << "pings are sent, not answered, so it is closed";
}

TEST_F(Live, AClientThatDoesNotReadIsNotListenedToAndHurtsNobody) {
  options.limits.queued_messages = 8;
  startWithRow();
  LiveClient deaf = connect();
  const auto ping = wire::encode({3, wire::Ping{42}});
  const std::string bytes(ping.begin(), ping.end());
  bool stopped = false;
  std::thread flood([&] {
    // Far more than the socket's buffers hold: the server stops reading, so sending stops as well.
    for (int i = 0; i < 400'000 && !stopped; ++i) stopped = !deaf.sendFrame(2, bytes);
  });
  LiveClient polite = connect();
  ASSERT_TRUE(polite.openView(1));
  for (int i = 0; i < 50; ++i) {
    polite.send(cameraAt(i));
    ASSERT_TRUE(polite.await<wire::Answer>());
  }
  deaf.socket().shutdownWrite();
  server.reset();
  flood.join();
}

TEST_F(Live, GoesAwayPolitelyOnDrain) {
  startWithRow();
  std::optional<LiveClient> client(connect());
  ASSERT_TRUE(client->openView(1));
  client->send(cameraAt(1));
  const auto start = std::chrono::steady_clock::now();
  std::thread drain([this] { server->drain(); });
  EXPECT_TRUE(client->await<wire::GoAway>());
  auto frame = client->receiveFrame();
  while (frame && frame->opcode == 2) frame = client->receiveFrame();  // the answer may come after
  EXPECT_TRUE(frame && frame->opcode == 8 && frame->closeCode() == 1001);
  client->sendFrame(8, frame ? frame->payload : "");
  EXPECT_TRUE(client->socket().readToEnd());
  client.reset();
  drain.join();
  EXPECT_LT(std::chrono::steady_clock::now() - start, options.limits.drain_timeout);
  EXPECT_FALSE(socket().connected()) << "nobody listens any more";
}

TEST_F(Live, SurvivesClientsThatVanishAtAnyMoment) {
  startWithRow();
  for (int i = 0; i < 60; ++i) {
    LiveClient client(socket(), "row");
    if (i % 6 > 0) client.send(wire::Hello{1, 1, "brief"});
    if (i % 6 > 1) client.send(wire::OpenView{1, "", false});
    if (i % 6 > 2) client.send(cameraAt(i));
    if (i % 6 > 3) client.send(wire::Edit{0, {{wire::EditKind::kHide, 1, {}}}});
    if (i % 6 > 4) client.socket().shutdownWrite();
  }
  LiveClient client = connect();
  ASSERT_TRUE(client.openView(1));
  client.send(cameraAt(1));
  EXPECT_TRUE(client.await<wire::Answer>());
}

}  // namespace
}  // namespace culld::testing
