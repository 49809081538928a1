// The daemon for as long as one likes: clients come and go, cameras, edits, uploads and removals,
// lap after lap. What it holds after a lap is what it held before. CULLD_LONG=1: ten minutes.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <numeric>
#include <thread>

#include "protocol/id_set.h"
#include "tests/integration/server_fixture.h"
#include "tests/scenes/city.h"
#include "tests/scenes/random.h"

namespace culld::testing {
namespace {

namespace wire = protocol;
using scenes::Random;
using SteadyClock = std::chrono::steady_clock;

constexpr int kClients = 8;
constexpr std::uint32_t kObjects = 3'000;

std::chrono::seconds soakTime() {
  return std::chrono::seconds(std::getenv("CULLD_LONG") != nullptr ? 600 : 6);
}

struct Held {
  std::size_t descriptors = 0;
  std::size_t heap_bytes = 0;
};

std::size_t descriptorsNow() {
  const std::filesystem::directory_iterator files("/proc/self/fd");
  return static_cast<std::size_t>(std::distance(begin(files), end(files)));
}

/// Once no more than `descriptors` are open, or `patience` has passed: a connection that no longer
/// counts may still have to close its socket.
Held heldAtRest(std::size_t descriptors, std::chrono::milliseconds patience) {
  const auto until = SteadyClock::now() + patience;
  std::size_t least = descriptorsNow();
  while (least > descriptors && SteadyClock::now() < until) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
    least = std::min(least, descriptorsNow());
  }
  const struct mallinfo2 heap = ::mallinfo2();
  return {least, heap.uordblks + heap.hblkhd};
}

std::string bytesOf(const scenes::Model& model) {
  const auto bytes = scenes::toGlb(model);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// What one client saw in one lap.
struct Diary {
  std::vector<double> round_trips_ms;
  std::vector<std::string> faults;
};

class Soak : public ServerTest {
 protected:
  void startWithCity() {
    options.data_folder = (folder / "data").string();
    options.listen_port = 0;
    options.threads = 2;
    options.methods = allMethods();
    auto started = server::Server::start(options);
    ASSERT_TRUE(started.ok()) << started.error().message;
    server = std::move(started).value();
    ASSERT_TRUE(server->loadScenes().ok());
    EXPECT_EQ(request(port(), "PUT", "/v1/scenes/city", bytesOf(city.model)).status, 201);
  }

  wire::CameraUpdate cameraOf(Random& random, std::uint32_t view, std::uint32_t ack) const {
    const auto& spec = city.cameras[random.below(static_cast<std::uint32_t>(city.cameras.size()))];
    const auto& pose = std::get<LookAt>(spec.pose);
    wire::LookAt look;
    for (int i = 0; i < 3; ++i) {
      look.eye[static_cast<std::size_t>(i)] = pose.eye[i];
      look.target[static_cast<std::size_t>(i)] = pose.target[i];
      look.up[static_cast<std::size_t>(i)] = pose.up[i];
    }
    wire::CameraUpdate update{view, {look, 320, 180}, {}, ack};
    if (random.chance(0.2)) update.camera.radius_m = 0.3;
    return update;
  }

  /// Connects, opens views, asks, and leaves: now with a goodbye, now without.
  void visit(const std::string& scene, Random& random, Diary& diary) const {
    LiveClient client(socket(), scene);
    const bool stays = scene == "city";  // the guest comes and goes
    const auto lost = [&](const char* what) {
      if (stays) diary.faults.push_back(std::string("city: ") + what);
    };
    if (client.upgradeStatus() == 404) return lost("not known");
    if (client.upgradeStatus() != 101 || !client.hello()) {
      return diary.faults.push_back("no session with " + scene);
    }
    const std::uint32_t views = 1 + random.below(3);
    std::map<std::uint32_t, std::map<std::uint32_t, wire::IdSet>> held;
    std::vector<std::uint32_t> acks(views + 1, 0);
    for (std::uint32_t view = 1; view <= views; ++view) {
      if (!client.openView(view)) return lost("no view");
    }
    for (int i = 0; i < 12; ++i) {
      const std::uint32_t view = 1 + random.below(views);
      const auto asked = SteadyClock::now();
      client.send(cameraOf(random, view, acks[view]));
      const auto answer = client.await<wire::Answer>();
      if (!answer) return lost("no answer");
      diary.round_trips_ms.push_back(
          std::chrono::duration<double, std::milli>(SteadyClock::now() - asked).count());
      if (answer->baseline != 0 && !held[view].contains(answer->baseline)) {
        return diary.faults.push_back("a change of a frame that was never sent");
      }
      auto set = wire::decodeSet(answer->encoding, answer->payload, answer->scene_objects,
                                 held[view][answer->baseline]);
      if (!set.ok() || wire::setHash(set.value()) != answer->set_hash) {
        return diary.faults.push_back("a set that does not add up");
      }
      held[view][answer->frame] = std::move(set).value();
      acks[view] = stays ? answer->frame : 0;  // the guest may be another by now
    }
    if (random.chance(0.5)) client.sendFrame(8, "\x03\xe8");
  }

  void edit(Random& random, Diary& diary) const {
    LiveClient client(socket(), "city");
    if (!client.hello()) return diary.faults.push_back("no session for edits");
    for (int i = 0; i < 40; ++i) {
      const std::uint32_t object = random.below(kObjects);
      const auto kind = random.chance(0.5) ? wire::EditKind::kHide : wire::EditKind::kShow;
      client.send(wire::Edit{0, {{kind, object, {}}}});
      if (!client.await<wire::Edited>()) return diary.faults.push_back("an edit without an end");
    }
  }

  void upload(Diary& diary) const {
    for (const std::uint32_t objects : {200U, 900U}) {
      const int status = request(port(), "PUT", "/v1/scenes/guest", rowGlb(objects)).status;
      if (status != 200 && status != 201) diary.faults.push_back("an upload refused");
    }
    if (request(port(), "DELETE", "/v1/scenes/guest").status != 204) {
      diary.faults.push_back("a removal refused");
    }
  }

  Diary lap(std::uint64_t number) const {
    std::vector<Diary> diaries(kClients + 2);
    std::vector<std::thread> people;
    for (std::size_t c = 0; c < kClients; ++c) {
      people.emplace_back([this, c, number, &diary = diaries[c]] {
        Random random(number * 100 + c);
        for (int i = 0; i < 4; ++i) visit(i == 2 ? "guest" : "city", random, diary);
      });
    }
    people.emplace_back([this, number, &diary = diaries[kClients]] {
      Random random(number);
      edit(random, diary);
    });
    people.emplace_back([this, &diary = diaries[kClients + 1]] { upload(diary); });
    for (std::thread& one : people) one.join();
    Diary all;
    for (Diary& one : diaries) {
      std::move(one.faults.begin(), one.faults.end(), std::back_inserter(all.faults));
      all.round_trips_ms.insert(all.round_trips_ms.end(), one.round_trips_ms.begin(),
                                one.round_trips_ms.end());
    }
    EXPECT_TRUE(awaitNoConnections(std::chrono::seconds(5)));
    return all;
  }

  const scenes::City city = scenes::generateCity({.seed = 2, .objects = kObjects, .frames = 40});
};

double percentile(std::vector<double> of, double share) {
  if (of.empty()) return 0;
  const auto at =
      of.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(of.size() - 1));
  std::nth_element(of.begin(), at, of.end());
  return *at;
}

TEST_F(Soak, HoldsAfterALapWhatItHeldBefore) {
  startWithCity();
  constexpr std::uint64_t kWarmUp = 3;  // caches, pools and the method's plans fill
  Held before, after;
  std::size_t answers = 0;
  std::uint64_t number = 0;
  const auto until = SteadyClock::now() + soakTime();
  for (; number < kWarmUp + 3 || SteadyClock::now() < until; ++number) {
    const Diary diary = lap(number);
    for (const std::string& fault : diary.faults)
      ADD_FAILURE() << "lap " << number << ": " << fault;
    answers += diary.round_trips_ms.size();
    if (number + 1 == kWarmUp) before = heldAtRest(0, std::chrono::milliseconds(300));
    after = heldAtRest(before.descriptors, std::chrono::seconds(number < kWarmUp ? 0 : 5));
    if ((number & (number - 1)) == 0) {
      std::printf("lap %3llu: p50 %.2f ms, p99 %.2f ms, %zu descriptors, %.2f MB of heap\n",
                  static_cast<unsigned long long>(number), percentile(diary.round_trips_ms, 0.5),
                  percentile(diary.round_trips_ms, 0.99), after.descriptors,
                  static_cast<double>(after.heap_bytes) * 1e-6);
    }
  }
  std::printf("%llu laps, %zu answers: %zu -> %zu descriptors, %.2f -> %.2f MB of heap\n",
              static_cast<unsigned long long>(number), answers, before.descriptors,
              after.descriptors, static_cast<double>(before.heap_bytes) * 1e-6,
              static_cast<double>(after.heap_bytes) * 1e-6);
  EXPECT_GT(answers, 500U);
  EXPECT_LE(after.descriptors, before.descriptors);
#ifndef CULLD_SANITIZED  // their heaps say nothing to mallinfo2
  EXPECT_LT(after.heap_bytes, before.heap_bytes + before.heap_bytes / 20 + 500'000);
#endif
}

}  // namespace
}  // namespace culld::testing
