// Clients that take more than their share of a server: of its connections, its memory, its time.
// What each gets is docs/protocol.md "Limits".
#include <gtest/gtest.h>

#include <random>
#include <thread>

#include "protocol/codec.h"
#include "tests/integration/gate.h"
#include "tests/integration/server_fixture.h"

namespace culld::testing {
namespace {

namespace wire = protocol;
using namespace std::chrono_literals;
using SteadyClock = std::chrono::steady_clock;

class LiveLimits : public ServerTest {
 protected:
  LiveClient connect() {
    LiveClient client(socket(), "row");
    EXPECT_EQ(client.upgradeStatus(), 101);
    EXPECT_TRUE(client.hello().has_value());
    return client;
  }
  static bool converses(LiveClient& client) {
    client.send(wire::Ping{1});
    return client.await<wire::Pong>().has_value();
  }
  /// Asks and never reads until nothing more is taken, and says how many bytes were sent.
  /// REQUIRES: no limit on messages per second, which would stop it as well.
  double floodUntilStopped(LiveClient& deaf) const {
    const double bytes = static_cast<double>(wire::encode({1, wire::Ping{1}}).size());
    deaf.socket().setPatience(500ms);
    double sent = 0;
    while (sent < 64e6 && deaf.send(wire::Ping{1})) sent += bytes;
    return sent;
  }
  double receivedBytes() const {
    const std::string text = request(port(), "GET", "/metrics").body;
    const auto at = text.find("\nculld_received_bytes_total ");
    return at == std::string::npos ? -1.0 : std::stod(text.substr(at + 28));
  }
  void expectADeafClientIsStoppedAlone() {
    options.limits.session.max_messages_per_s = 0;
    startWithRow();
    LiveClient deaf = connect();
    LiveClient polite = connect();
    const double sent = floodUntilStopped(deaf);
    // A server that is merely slow gets to the end of what was sent.
    double received = receivedBytes();
    for (double before = -1; received > before; received = receivedBytes()) {
      before = received;
      std::this_thread::sleep_for(300ms);
    }
    EXPECT_GT(received, 0.0);
    EXPECT_LT(received, sent) << "all that was sent was read";
    EXPECT_TRUE(converses(polite));
  }
};

TEST_F(LiveLimits, QueuedBytesStopTheReading) {
  options.limits.queued_bytes = 1000;
  options.limits.queued_messages = 1'000'000'000;
  expectADeafClientIsStoppedAlone();
}

TEST_F(LiveLimits, QueuedMessagesStopTheReading) {
  options.limits.queued_bytes = 1'000'000'000;
  options.limits.queued_messages = 8;
  expectADeafClientIsStoppedAlone();
}

TEST_F(LiveLimits, BytesQueuedForAllStopThoseWhoDoNotRead) {
  options.limits.queued_bytes = 1'000'000'000;
  options.limits.queued_messages = 1'000'000'000;
  options.limits.total_queued_bytes = 1000;
  expectADeafClientIsStoppedAlone();
}

TEST_F(LiveLimits, WhoReadsAgainIsListenedToAgain) {
  options.limits.queued_messages = 4;
  startWithRow();
  LiveClient client = connect();
  constexpr std::uint64_t kPings = 20'000;
  std::thread asks([&client] {
    for (std::uint64_t i = 1; i <= kPings; ++i) client.send(wire::Ping{i}, i);
  });
  std::this_thread::sleep_for(50ms);
  std::uint64_t replies = 0;
  std::uint64_t id = 0;
  while (replies < kPings && client.await<wire::Pong>(&id)) EXPECT_EQ(id, ++replies);
  EXPECT_EQ(replies, kPings);
  asks.join();
}

TEST_F(LiveLimits, AMessageThatNobodyTakesEndsTheConnection) {
  options.limits.session.max_messages_per_s = 0;
  options.limits.write_timeout = 300ms;
  options.limits.min_upload_bytes_per_s = 1'000'000'000;
  startWithRow();
  LiveClient deaf = connect();
  floodUntilStopped(deaf);
  EXPECT_TRUE(awaitNoConnections(10s));
}

TEST_F(LiveLimits, SoDoesAReplyThatNobodyTakes) {
  options.limits.write_timeout = 300ms;
  startWithRow(100'000);
  RawSocket deaf = socket();
  for (int i = 0; i < 40; ++i) {  // more than a megabyte each
    deaf.send("GET /v1/scenes/row/objects HTTP/1.1\r\nHost: x\r\n\r\n");
  }
  EXPECT_TRUE(awaitNoConnections(20s));
}

TEST_F(LiveLimits, ASlowReaderKeepsItsConnection) {
  options.limits.write_timeout = 400ms;
  startWithRow();
  LiveClient client = connect();
  for (int i = 0; i < 6; ++i) {  // longer than the limit in all, but each message is taken
    std::this_thread::sleep_for(100ms);
    EXPECT_TRUE(converses(client));
  }
}

TEST_F(LiveLimits, MessagesPerSecondAreEvenedOut) {
  options.limits.session.max_messages_per_s = 100;
  startWithRow();
  LiveClient client = connect();
  const auto start = SteadyClock::now();
  constexpr std::uint64_t kPings = 60;
  for (std::uint64_t i = 1; i <= kPings; ++i) client.send(wire::Ping{i}, i);
  std::uint64_t id = 0;
  for (std::uint64_t i = 1; i <= kPings; ++i) {
    ASSERT_TRUE(client.await<wire::Pong>(&id)) << "late, but never lost";
    EXPECT_EQ(id, i);
  }
  EXPECT_GE(SteadyClock::now() - start, 450ms) << "ten at once, then 10 ms for each";
}

TEST_F(LiveLimits, ConnectionsOfAnAddress) {
  options.limits.max_connections_per_address = 3;
  options.unix_path = (folder / "sock").string();
  start();
  std::vector<RawSocket> held;
  for (int i = 0; i < 3; ++i) held.push_back(socket());
  for (RawSocket& s : held) {
    s.send("GET /livez HTTP/1.1\r\nHost: x\r\n\r\n");
    EXPECT_EQ(readAnswer(s).status, 200);
  }
  RawSocket fourth = socket();
  const auto refusal = readAnswer(fourth);
  EXPECT_EQ(refusal.status, 503);
  EXPECT_EQ(refusal.body,
            "{\"error\":\"too many connections from this address: 3 are open, and no more are "
            "taken\"}\n");
  RawSocket local = RawSocket::unixDomain(options.unix_path);
  local.send("GET /livez HTTP/1.1\r\nHost: x\r\n\r\n");
  EXPECT_EQ(readAnswer(local).status, 200) << "the Unix socket has no addresses";
  held.pop_back();
  const auto until = SteadyClock::now() + 10s;
  int status = 0;
  while ((status = request(port(), "GET", "/livez").status) != 200 && SteadyClock::now() < until) {
    std::this_thread::sleep_for(10ms);
  }
  EXPECT_EQ(status, 200) << "a place was given back";
}

TEST_F(LiveLimits, ALiveConnectionStillCountsForItsAddress) {
  options.limits.max_connections_per_address = 2;
  startWithRow();
  std::vector<LiveClient> clients;  // the upload's place takes a moment to be free
  const auto until = SteadyClock::now() + 10s;
  while (clients.size() < 2 && SteadyClock::now() < until) {
    LiveClient client(socket(), "row");
    if (client.upgradeStatus() == 101) clients.push_back(std::move(client));
  }
  ASSERT_EQ(clients.size(), 2U);
  RawSocket third = socket();
  EXPECT_EQ(readAnswer(third).status, 503);
  for (LiveClient& client : clients) EXPECT_TRUE(client.hello() && converses(client));
}

TEST_F(LiveLimits, AHeaderThatTrickles) {
  options.limits.header_timeout = 300ms;
  start();
  RawSocket s = socket();
  const auto begun = SteadyClock::now();
  const std::string header = "GET /livez HTTP/1.1\r\nHost: x\r\nX: " + std::string(4000, 'x');
  for (const char byte : header) {
    if (!s.send({&byte, 1})) break;
    std::this_thread::sleep_for(10ms);
    if (SteadyClock::now() - begun > 10s) break;
  }
  EXPECT_LT(SteadyClock::now() - begun, 10s) << "each byte bought more time";
}

TEST_F(LiveLimits, AConversationInSingleBytes) {
  startWithRow();
  RawSocket slow = socket();
  slow.sendBytewise();
  LiveClient client(std::move(slow), "row");
  ASSERT_EQ(client.upgradeStatus(), 101);
  ASSERT_TRUE(client.hello());
  ASSERT_TRUE(client.openView(1));
  client.send(cameraAt(2), 10);
  const auto answer = client.await<wire::Answer>();
  ASSERT_TRUE(answer);
  EXPECT_EQ(answer->object_count, 100U);
}

TEST_F(LiveLimits, AHalfClosedSocketIsLetGo) {
  Gate gate;
  fake.on_cull = [&gate] { gate.pass(); };
  startWithRow();
  LiveClient client = connect();
  ASSERT_TRUE(client.openView(1));
  client.send(cameraAt(1));
  client.socket().shutdownWrite();
  EXPECT_TRUE(client.socket().readToEnd()) << "the server hangs up as well";
  gate.open();
  EXPECT_TRUE(awaitNoConnections(10s));
}

TEST_F(LiveLimits, GarbageAfterTheUpgradeHurtsNobody) {
  startWithRow();
  std::mt19937 random(7);
  std::uniform_int_distribution<int> byte(0, 255);
  for (int round = 0; round < 60; ++round) {
    LiveClient client(socket(), "row");
    if (round % 2 != 0) client.hello();
    std::string garbage(1 + random() % 4000, ' ');
    for (char& c : garbage) c = static_cast<char>(byte(random));
    client.socket().send(garbage);
    client.socket().shutdownWrite();
    EXPECT_TRUE(client.socket().readToEnd()) << "round " << round;
  }
  LiveClient client = connect();
  EXPECT_TRUE(converses(client));
}

TEST_F(LiveLimits, ADrainDoesNotWaitForEver) {
  Gate gate;
  fake.on_cull = [&gate] { gate.pass(); };
  options.limits.drain_timeout = 200ms;
  startWithRow();
  LiveClient client = connect();
  ASSERT_TRUE(client.openView(1));
  client.send(cameraAt(1));
  gate.awaitArrival();
  const auto begun = SteadyClock::now();
  server->drain();
  const auto took = SteadyClock::now() - begun;
  gate.open();
  server.reset();  // the cull leaves the gate before the test does
  EXPECT_GE(took, 200ms) << "what is in flight gets its time";
  EXPECT_LT(took, 5s);
}

TEST_F(LiveLimits, CancelAndDeadlinesOverASocket) {
  Gate gate;
  fake.on_cull = [&gate] { gate.pass(); };
  startWithRow();
  LiveClient client = connect();
  ASSERT_TRUE(client.openView(1));
  client.send(cameraAt(1), 10);
  gate.awaitArrival();
  wire::CameraUpdate hurried = cameraAt(2);
  hurried.deadline_us = 20'000;
  client.send(hurried, 11);
  std::uint64_t id = 0;
  auto refused = client.await<wire::ErrorReply>(&id);
  ASSERT_TRUE(refused);
  EXPECT_EQ(id, 11U);
  EXPECT_EQ(refused->code, wire::WireCode::kDeadlineExceeded);
  client.send(wire::Cancel{10}, 12);
  refused = client.await<wire::ErrorReply>(&id);
  ASSERT_TRUE(refused);
  EXPECT_EQ(id, 10U);
  EXPECT_EQ(refused->code, wire::WireCode::kCancelled);
  client.send(cameraAt(3), 13);
  gate.open();
  const auto answer = client.await<wire::Answer>(&id);
  ASSERT_TRUE(answer);
  EXPECT_EQ(id, 13U) << "the cancelled cull was carried out, and not sent";
}

}  // namespace
}  // namespace culld::testing
