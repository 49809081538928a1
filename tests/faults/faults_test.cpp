// The daemon behind a network that cuts, splits, delays and half-closes: what arrives is right,
// what was acknowledged holds, and nothing is left behind. CULLD_LONG=1 runs twenty times as many.
#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>
#include <thread>

#include "protocol/id_set.h"
#include "tests/faults/fault_proxy.h"
#include "tests/integration/server_fixture.h"
#include "tests/scenes/random.h"

namespace culld::testing {
namespace {

namespace wire = protocol;
using scenes::Random;

constexpr std::uint32_t kObjects = 2'000;
constexpr int kClients = 6;

int rounds(int usual) { return std::getenv("CULLD_LONG") != nullptr ? usual * 20 : usual; }

class Faults : public ServerTest {
 protected:
  void startBehindProxy(std::uint64_t seed, const FaultMix& mix = {}) {
    options.limits.header_timeout = std::chrono::milliseconds(2'000);
    options.limits.body_timeout = std::chrono::milliseconds(2'000);
    startWithRow(kObjects);
    proxy = std::make_unique<FaultProxy>(port(), seed, mix);
  }

  RawSocket throughProxy() const { return RawSocket::tcp(proxy->port()); }

  /// The status of the reply; 0 if none came.
  int putThroughProxy(const std::string& scene, const std::string& body) const {
    RawSocket socket = throughProxy();
    socket.send("PUT /v1/scenes/" + scene + " HTTP/1.1\r\nHost: x\r\nContent-Length: " +
                std::to_string(body.size()) + "\r\n\r\n");
    socket.send(body);
    return readAnswer(socket).status;
  }

  /// The objects that the server shows at x = 0, asked without the proxy.
  wire::IdSet shown(const std::string& scene) const {
    LiveClient client(socket(), scene);
    EXPECT_TRUE(client.hello().has_value());
    EXPECT_TRUE(client.openView(1));
    client.send(cameraAt(0));
    const auto answer = client.await<wire::Answer>();
    EXPECT_TRUE(answer.has_value());
    if (!answer) return {};
    return wire::decodeSet(answer->encoding, answer->payload, answer->scene_objects).value();
  }

  std::uint64_t objectsOf(const std::string& scene) const {
    const HttpAnswer reply = request(port(), "GET", "/v1/scenes/" + scene);
    if (reply.status != 200) return 0;
    return nlohmann::json::parse(reply.body).value("objects", std::uint64_t{0});
  }

  void expectNothingLeftBehind() {
    proxy.reset();
    EXPECT_TRUE(awaitNoConnections(std::chrono::seconds(8)));
    LiveClient healthy(socket(), "row");
    EXPECT_TRUE(healthy.hello().has_value());
  }

  std::unique_ptr<FaultProxy> proxy;
};

struct Conversations {
  std::uint64_t connections = 0, answers = 0, changes = 0, lost = 0;
  std::vector<std::string> faults;
};

/// One connection's cameras, until the network ends it or there were forty.
void converse(LiveClient& client, Random& random, const SceneSnapshot& scene, Conversations& seen) {
  std::map<std::uint32_t, wire::IdSet> held;
  std::uint32_t ack = 0;
  for (int i = 0; i < 40; ++i) {
    const auto x = static_cast<double>(random.below(9));
    wire::LookAt look;
    look.eye = {x, 0, 5};
    look.target = {x, 0, 0};
    wire::CameraUpdate update{1, {look}, {}, ack};
    client.send(update, static_cast<std::uint64_t>(i) + 10);
    const auto message = client.receive();
    if (!message) {
      ++seen.lost;
      return;
    }
    const auto* answer = std::get_if<wire::Answer>(&message->body);
    if (answer == nullptr) return seen.faults.push_back("no answer to camera " + std::to_string(i));
    const auto set = wire::decodeSet(answer->encoding, answer->payload, answer->scene_objects,
                                     held[answer->baseline]);
    if (!set.ok() || set.value() != server::fakeVisible(scene, x) ||
        answer->set_hash != wire::setHash(set.value())) {
      seen.faults.push_back("wrong answer to camera " + std::to_string(i));
      return;
    }
    held[answer->frame] = set.value();
    if (random.chance(0.8)) ack = answer->frame;
    ++seen.answers;
    seen.changes += answer->baseline != 0 ? 1U : 0U;
  }
}

TEST_F(Faults, NoAnswerThatArrivesIsWrong) {
  startBehindProxy(1);
  const SnapshotPtr scene = server::rowOfObjects(kObjects);
  std::vector<Conversations> seen(kClients);
  std::vector<std::thread> clients;
  for (int c = 0; c < kClients; ++c) {
    clients.emplace_back([this, c, &scene, &mine = seen[static_cast<std::size_t>(c)]] {
      Random random(static_cast<std::uint64_t>(c) + 1);
      for (int i = 0; i < rounds(25); ++i) {
        RawSocket socket = throughProxy();
        if (!socket.connected()) continue;
        LiveClient client(std::move(socket), "row");
        ++mine.connections;
        if (client.upgradeStatus() != 101 || !client.hello() || !client.openView(1)) continue;
        converse(client, random, *scene, mine);
      }
    });
  }
  for (std::thread& client : clients) client.join();
  Conversations all;
  for (const Conversations& one : seen) {
    for (const std::string& fault : one.faults) ADD_FAILURE() << fault;
    all.connections += one.connections;
    all.answers += one.answers;
    all.changes += one.changes;
    all.lost += one.lost;
  }
  const FaultCounts faults = proxy->stop();
  std::printf(
      "%llu connections, %llu answers (%llu as changes), %llu conversations cut; %llu "
      "resets, %llu half-closes\n",
      static_cast<unsigned long long>(all.connections),
      static_cast<unsigned long long>(all.answers), static_cast<unsigned long long>(all.changes),
      static_cast<unsigned long long>(all.lost), static_cast<unsigned long long>(faults.resets),
      static_cast<unsigned long long>(faults.half_closes));
  EXPECT_GT(all.answers, 500U);
  EXPECT_GT(all.changes, 100U);
  EXPECT_GT(faults.resets, 10U);
  EXPECT_GT(faults.half_closes, 5U);
  expectNothingLeftBehind();
}

TEST_F(Faults, AnUploadIsWholeOrWasNeverMade) {
  startBehindProxy(2, {.reset = 0.4, .half_close = 0.2, .fault_within_bytes = 12'000});
  Random random(7);
  std::uint64_t held = 0, acknowledged = 0, failed = 0;
  for (int i = 0; i < rounds(40); ++i) {
    const std::uint32_t objects = 50 + random.below(400);
    const int status = putThroughProxy("up", rowGlb(objects));
    const std::uint64_t now = objectsOf("up");
    if (status == 200 || status == 201) {
      EXPECT_EQ(now, objects) << "acknowledged, and not there";
      ++acknowledged;
    } else {  // the reply may have been lost, or the upload may still be loading
      EXPECT_TRUE(status == 0 || status == 400 || status == 408)
          << status << ": not the network's doing";
      EXPECT_TRUE(now == held || now == objects) << now << " objects: of no upload at all";
      ++failed;
      EXPECT_TRUE(awaitNoConnections(std::chrono::seconds(5)));
    }
    held = objectsOf("up");
  }
  EXPECT_GT(acknowledged, 5U);
  EXPECT_GT(failed, 5U);
  expectNothingLeftBehind();
}

TEST_F(Faults, AnAcknowledgedEditHolds) {
  startBehindProxy(3, {.reset = 0.5, .fault_within_bytes = 3'000});
  Random random(11);
  std::set<std::uint32_t> hidden, perhaps;
  for (std::uint32_t next = 0; next < 600;) {
    LiveClient client(throughProxy(), "row");
    if (client.upgradeStatus() != 101 || !client.hello()) continue;
    for (; next < 600; ++next) {
      const std::uint32_t object = next * 3;  // shown at x = 0
      client.send(wire::Edit{0, {{wire::EditKind::kHide, object, {}}}}, next + 1);
      const bool done = client.await<wire::Edited>().has_value();
      (done ? hidden : perhaps).insert(object);
      if (!done) break;
    }
    ++next;
  }
  const wire::IdSet now = shown("row");
  for (const std::uint32_t object : now) {
    EXPECT_FALSE(hidden.contains(object)) << object << " was acknowledged as hidden";
  }
  const std::size_t all = (kObjects + 2) / 3;
  EXPECT_GE(now.size(), all - hidden.size() - perhaps.size());
  EXPECT_LE(now.size(), all - hidden.size());
  EXPECT_GT(hidden.size(), 200U);
  EXPECT_GT(perhaps.size(), 5U);
  expectNothingLeftBehind();
}

}  // namespace
}  // namespace culld::testing
