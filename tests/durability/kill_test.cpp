// kill -9 at random moments, with uploads, replacements, removals and edits under way. What clients
// were told is there after the restart; what they were not told is there whole or not at all.
// CULLD_KILL_SEED names the run, CULLD_LONG=1 makes it a thousand kills.
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <thread>

#include "tests/durability/known_scene.h"
#include "tests/scenes/rounds.h"

namespace culld::testing {
namespace {

namespace fs = std::filesystem;
namespace wire = protocol;
using scenes::Random;

int kills() {
  return std::getenv("CULLD_LONG") != nullptr ? static_cast<int>(scenes::rounds(1000)) : 20;
}

std::uint64_t seed() {
  const char* given = std::getenv("CULLD_KILL_SEED");
  return given == nullptr ? 1 : std::strtoull(given, nullptr, 10);
}

struct Counts {
  int uploads = 0, replacements = 0, removals = 0, edits = 0, unknown = 0;
};

/// One scene and the only client that changes it. `states` begins with the one that was
/// acknowledged last; those after it came of requests without a reply yet, in their order.
class Owner {
 public:
  Owner(const Daemon& daemon, std::string name, std::uint64_t seed)
      : daemon_(daemon), name_(std::move(name)), random_(seed) {}

  /// Until the daemon is gone.
  void run() {
    while (step()) {
    }
  }

  /// Of what may be, what is; that it is nothing else.
  void settle() {
    const ToldScene told = askScene(daemon_, name_);
    for (std::size_t i = 0; i < states_.size(); ++i) {
      if (!same(told, states_[i])) continue;
      counts.unknown += i > 0 ? 1 : 0;
      states_ = {states_[i]};
      EXPECT_TRUE(states_[0] == nullptr || answersAs(daemon_, name_, states_[0])) << name_;
      return;
    }
    ADD_FAILURE() << name_ << ": " << told.status << ", version " << told.version << ", "
                  << told.objects << " objects, " << told.hash << "; acknowledged was "
                  << describe(states_[0]) << ", and " << states_.size() - 1 << " were under way";
    states_ = {nullptr};
    daemon_.ask("DELETE", path());
  }

  Counts counts;

 private:
  std::string path() const { return "/v1/scenes/" + name_; }

  bool step() {
    if (states_[0] == nullptr || random_.chance(0.1)) return upload();
    if (random_.chance(0.05)) return remove();
    return edit();
  }

  bool upload() {
    const std::uint32_t objects =
        random_.chance(0.1) ? 8000 + random_.below(8000) : 20 + random_.below(300);
    const std::string glb = rowGlb(objects);
    states_.push_back(loaded(glb));
    const int expected = states_[0] == nullptr ? 201 : 200;
    const int status = daemon_.ask("PUT", path(), glb).status;
    if (status == 0) return false;
    EXPECT_EQ(status, expected) << name_;
    ++(expected == 201 ? counts.uploads : counts.replacements);
    states_.erase(states_.begin());
    return true;
  }

  bool remove() {
    states_.push_back(nullptr);
    const int status = daemon_.ask("DELETE", path()).status;
    if (status == 0) return false;
    EXPECT_EQ(status, 204) << name_;
    ++counts.removals;
    states_.erase(states_.begin());
    return true;
  }

  /// Some edits, sent without waiting for each other.
  bool edit() {
    LiveClient client(daemon_.connect(), name_);
    EXPECT_TRUE(client.upgradeStatus() == 0 || client.upgradeStatus() == 101) << name_;
    if (client.upgradeStatus() == 0 || !client.hello()) return false;
    for (std::uint32_t rounds = 1 + random_.below(20); rounds > 0; --rounds) {
      const std::uint32_t together = 1 + random_.below(5);
      for (std::uint32_t i = 0; i < together; ++i) {
        KnownEdit edit = randomEdit(random_, states_.back());
        if (edit.items.empty()) break;
        states_.push_back(edit.after);
        if (!client.send(wire::Edit{0, std::move(edit.items)}, i + 1)) return false;
      }
      while (states_.size() > 1) {
        const auto done = client.await<wire::Edited>();
        if (!done) return false;
        EXPECT_EQ(done->scene_version, states_[1]->version()) << name_;
        for (const std::uint32_t id : done->added) EXPECT_LT(id, states_[1]->objectCount());
        states_.erase(states_.begin());
        ++counts.edits;
      }
    }
    return true;
  }

  const Daemon& daemon_;
  const std::string name_;
  Random random_;
  std::vector<SnapshotPtr> states_{nullptr};
};

/// Several clients edit one scene, each its own objects, so that commits are shared.
class Crowd {
 public:
  static constexpr std::size_t kEditors = 3;
  Crowd(const Daemon& daemon, std::uint64_t seed) : daemon_(daemon), random_(seed) {}

  bool begin() {
    const std::string glb = rowGlb(90);
    acknowledged_ = loaded(glb);
    return daemon_.ask("PUT", "/v1/scenes/crowd", glb).status == 201;
  }

  void run(std::size_t editor, std::uint64_t seed) {
    Random random(seed);
    std::vector<std::uint32_t> mine;
    for (std::uint32_t id = static_cast<std::uint32_t>(editor); id < 90; id += kEditors) {
      mine.push_back(id);
    }
    LiveClient client(daemon_.connect(), "crowd");
    EXPECT_TRUE(client.upgradeStatus() == 0 || client.upgradeStatus() == 101) << "crowd";
    if (client.upgradeStatus() == 0 || !client.hello()) return;
    const SnapshotPtr base = acknowledged_;
    for (;;) {
      under_way_[editor] = randomEdit(random, base, mine).items;
      if (!client.send(wire::Edit{0, under_way_[editor]}, 1)) return;
      if (!client.await<wire::Edited>()) return;
      done_[editor].push_back(std::exchange(under_way_[editor], {}));
    }
  }

  /// All that was acknowledged is there, and of what was under way any part.
  void settle(Counts& counts) {
    SnapshotPtr sure = acknowledged_;
    for (auto& edits : done_) {
      counts.edits += static_cast<int>(edits.size());
      for (const auto& items : edits) sure = applied(sure, items);
      edits.clear();
    }
    const ToldScene told = askScene(daemon_, "crowd");
    for (unsigned subset = 0; subset < 1U << kEditors; ++subset) {
      SnapshotPtr scene = sure;
      for (std::size_t i = 0; i < kEditors; ++i) {
        if ((subset >> i & 1U) == 0) continue;
        if (under_way_[i].empty()) scene = nullptr;
        if (scene != nullptr) scene = applied(scene, under_way_[i]);
      }
      if (scene == nullptr || !same(told, scene)) continue;
      counts.unknown += subset != 0 ? 1 : 0;
      acknowledged_ = scene;
      for (auto& items : under_way_) items.clear();
      EXPECT_TRUE(answersAs(daemon_, "crowd", scene));
      return;
    }
    ADD_FAILURE() << "crowd: version " << told.version << ", " << told.hash << "; acknowledged was "
                  << describe(sure);
  }

 private:
  const Daemon& daemon_;
  Random random_;
  SnapshotPtr acknowledged_;
  std::array<std::vector<std::vector<wire::EditItem>>, kEditors> done_;
  std::array<std::vector<wire::EditItem>, kEditors> under_way_;
};

class KillTest : public ::testing::Test {
 protected:
  KillTest() {
    fs::remove_all(folder);
    fs::create_directories(folder);
  }
  ~KillTest() override {
    daemon.kill();
    fs::remove_all(folder);
  }

  void expectNothingHalf() const {
    EXPECT_TRUE(fs::is_empty(data() / "uploads")) << "a half upload";
    for (const auto& entry : fs::directory_iterator(data() / "edits")) {
      EXPECT_FALSE(entry.path().filename().string().starts_with("~tmp~")) << entry.path();
    }
    const std::string log = daemon.log();
    EXPECT_EQ(log.find("is not served"), std::string::npos) << log;
    EXPECT_EQ(log.find("left alone"), std::string::npos) << log;
  }
  fs::path data() const { return folder / "data"; }

  const fs::path folder =
      fs::path(::testing::TempDir()) / ("culld_kill_" + std::to_string(::getpid()));
  Daemon daemon{folder / "data"};
};

TEST_F(KillTest, WhatWasAcknowledgedIsThereAfterwards) {
  std::printf("seed %llu\n", static_cast<unsigned long long>(seed()));
  Random random(seed());
  std::vector<std::unique_ptr<Owner>> owners;
  for (int i = 0; i < 4; ++i) {
    owners.push_back(std::make_unique<Owner>(daemon, "scene" + std::to_string(i), random.seed()));
  }
  Crowd crowd(daemon, random.seed());
  ASSERT_TRUE(daemon.start()) << daemon.log();
  ASSERT_TRUE(crowd.begin());
  Counts total;
  for (int kill = 0; kill < kills() && !HasFailure(); ++kill) {
    std::vector<std::thread> clients;
    for (auto& owner : owners) clients.emplace_back([&owner] { owner->run(); });
    for (std::size_t i = 0; i < Crowd::kEditors; ++i) {
      clients.emplace_back([&crowd, i, seed = random.seed()] { crowd.run(i, seed); });
    }
    std::this_thread::sleep_for(std::chrono::microseconds(1000 + random.below(200'000)));
    daemon.kill();
    for (std::thread& client : clients) client.join();
    if (random.chance(0.3)) {  // and again while it starts
      daemon.launch();
      std::this_thread::sleep_for(std::chrono::microseconds(1000 + random.below(80'000)));
      daemon.kill();
    }
    ASSERT_TRUE(daemon.start()) << daemon.log();
    expectNothingHalf();
    for (auto& owner : owners) owner->settle();
    crowd.settle(total);
  }
  for (const auto& owner : owners) {
    total.uploads += owner->counts.uploads;
    total.replacements += owner->counts.replacements;
    total.removals += owner->counts.removals;
    total.edits += owner->counts.edits;
    total.unknown += owner->counts.unknown;
  }
  std::printf(
      "%d kills; acknowledged: %d uploads, %d replacements, %d removals, %d edits; %d times "
      "something was there that had not been acknowledged yet\n",
      kills(), total.uploads, total.replacements, total.removals, total.edits, total.unknown);
  EXPECT_GT(total.uploads, 3);
  EXPECT_GT(total.replacements, 3);
  EXPECT_GT(total.edits, 100);
}

}  // namespace
}  // namespace culld::testing
