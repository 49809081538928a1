// Many clients of one scene in virtual time: what is said, when jobs end and in which order, what
// leaves the socket, who hangs up, is drawn from a seed. A model of what docs/protocol.md promises
// watches every step. CULLD_SEED=N runs one seed alone; CULLD_LONG=1 runs twenty times as many.
#include <gtest/gtest.h>

#include <cstdlib>
#include <random>

#include "tests/scenes/rounds.h"
#include "tests/unit/server/session_model.h"

namespace culld::server {
namespace {

using namespace std::chrono_literals;

class Simulation {
 public:
  Simulation(std::uint64_t seed, Tally& tally) : random_(seed), tally_(tally) {
    limits_.max_views = 3;
    limits_.max_waiting_edits = 2;
    limits_.kept_frames = 3;
    limits_.max_requests_in_flight = 4;
    fake_.on_cull = [this] { pass(300us); };  // culls take time, some of them past a deadline
    for (int i = 0; i < 4; ++i) admit();
  }

  void run(int steps) {
    for (int i = 0; i < steps && !::testing::Test::HasFailure(); ++i) step();
    settle();
  }

 private:
  std::uint64_t below(std::uint64_t n) { return random_() % n; }
  void pass(std::chrono::microseconds most) {
    clock_.time += std::chrono::microseconds(below(static_cast<std::uint64_t>(most.count())));
  }
  Conversation& anyone() { return *clients_[below(clients_.size())]; }
  void admit() {
    clients_.push_back(std::make_unique<Conversation>(scene_, limits_, clock_, tally_));
    clients_.back()->openView(1);
  }
  void sceneMoved() {
    for (auto& client : clients_) {
      if (below(4) != 0) client->sceneMoved();  // the others hear of it later, or by their answers
    }
  }

  void step() {
    pass(200us);
    for (auto& client : clients_) client->tick();
    Conversation& client = anyone();
    const std::uint64_t kind = below(100);
    if (kind < 65) return work(client);
    if (client.gone()) return replace(client);
    if (kind < 98) return talk(client);
    disturb(client);
  }

  void work(Conversation& client) {
    switch (below(3)) {
      case 0:
        client.finishCull(below(8));
        return;
      case 1:
        client.reportSent();
        return;
      default:
        if (client.finishEdit()) sceneMoved();
    }
  }

  void talk(Conversation& client) {
    // Mostly one view and one direction, so that sets change little.
    const auto view = static_cast<std::uint32_t>(below(3) != 0 ? 1 : 1 + below(4));
    const double x = below(4) == 0 ? static_cast<double>(below(9)) : 0.0;
    if (!client.hasOpen(view) && below(8) != 0) return client.openView(view);
    switch (below(24)) {
      case 0:
        return client.openView(view);
      case 1:
        return client.closeView(view);
      case 2:
        return client.cancel(0);
      case 3:
      case 4:
        return client.cancel(below(5));
      case 5:
      case 6:
        return edit(client);
      default:
        const auto deadline = std::chrono::microseconds(below(8) < 3 ? 1 + below(3000) : 0);
        return client.sendCamera(view, x, deadline, below(5) != 0);
    }
  }

  void edit(Conversation& client) {
    constexpr std::array<double, 12> kPose = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const auto kind = static_cast<wire::EditKind>(below(5));
    client.sendEdit({kind, static_cast<ObjectId>(below(26)), kPose});
  }

  void disturb(Conversation& client) {
    switch (below(6)) {
      case 0:
        if (below(2) == 0) return;
        scene_->replace(rowOfObjects(20 + static_cast<std::uint32_t>(below(5))));
        return sceneMoved();
      case 1:
        return client.hangUp();
      case 2:
        if (below(4) == 0) client.goAway();
        return;
      case 3:
        return client.garbage(random_);
      default:
        pass(5000us);
    }
  }

  void replace(Conversation& client) {
    if (client.busy() || below(4) != 0) return;
    client.checkRest();
    std::erase_if(clients_, [&client](const auto& held) { return held.get() == &client; });
    admit();
  }

  /// Everything catches up: no more is said, all work ends, all that is sent leaves.
  void settle() {
    for (auto& client : clients_) client->sceneMoved();
    const auto busy = [](const auto& client) { return client->busy(); };
    for (int i = 0; i < 10'000 && std::any_of(clients_.begin(), clients_.end(), busy); ++i) {
      for (auto& client : clients_) {
        client->finishCull(below(8));
        if (client->finishEdit()) sceneMoved();
        client->reportSent();
      }
    }
    for (auto& client : clients_) {
      EXPECT_FALSE(client->busy());
      client->checkRest();
    }
  }

  Random random_;
  Tally& tally_;
  TestClock clock_;
  SessionLimits limits_;
  FakeMethod fake_;
  const Method* table_[1] = {&fake_};
  std::shared_ptr<Scene> scene_ = std::make_shared<Scene>("s", Methods(table_), rowOfObjects(24));
  std::vector<std::unique_ptr<Conversation>> clients_;
};

unsigned long long ull(std::uint64_t n) { return n; }

TEST(SessionSimulation, KeepsItsPromisesWhateverComesFirst) {
  const char* one = std::getenv("CULLD_SEED");
  const std::uint64_t first = one != nullptr ? std::stoull(one) : 1;
  const bool is_long = std::getenv("CULLD_LONG") != nullptr;
  const std::uint64_t seeds = one != nullptr ? 1 : scenes::rounds(is_long ? 60'000 : 3000);
  Tally tally;
  for (std::uint64_t seed = first; seed < first + seeds; ++seed) {
    Simulation(seed, tally).run(500);
    ASSERT_FALSE(::testing::Test::HasFailure()) << "repeat with CULLD_SEED=" << seed;
  }
  std::printf(
      "%llu answers (%llu as changes), %llu cameras superseded, %llu edits, %llu scenes "
      "replaced, %llu hung up\n",
      ull(tally.answers), ull(tally.changes), ull(tally.superseded), ull(tally.edited),
      ull(tally.replaced), ull(tally.gone));
  for (const auto& [code, count] : tally.refusals) {
    std::printf("  %s: %llu\n", wire::wireCodeName(code).c_str(), ull(count));
  }
  if (one != nullptr) return;
  for (const std::uint64_t count :
       {tally.answers, tally.changes, tally.superseded, tally.edited, tally.replaced, tally.gone}) {
    EXPECT_GT(count, seeds);
  }
  for (const auto code : {wire::WireCode::kCancelled, wire::WireCode::kDeadlineExceeded,
                          wire::WireCode::kLimitExceeded, wire::WireCode::kInvalidEdit,
                          wire::WireCode::kUnknownView, wire::WireCode::kUnavailable}) {
    EXPECT_GT(tally.refusals[code], seeds / 2) << wire::wireCodeName(code);
  }
}

}  // namespace
}  // namespace culld::server
