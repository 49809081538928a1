#include "server/fair_queue.h"

#include <gtest/gtest.h>

#include <map>

namespace culld::server {
namespace {

using namespace std::chrono_literals;

/// One worker that takes what the queue gives it; each tenant's work costs what the test says.
class FairQueueTest : public ::testing::Test {
 protected:
  void push(const std::string& tenant, std::size_t count = 1) {
    for (std::size_t i = 0; i < count; ++i) {
      queue.push(tenant, [] {});
    }
  }
  /// Who was served.
  std::string serve() {
    const auto item = queue.pop();
    if (!item) return "nobody";
    queue.charge(item->payer, cost[item->payer]);
    used[item->payer] += cost[item->payer];
    return item->payer;
  }
  void serve(std::size_t items) {
    for (std::size_t i = 0; i < items; ++i) serve();
  }

  FairQueue queue;
  std::map<std::string, std::chrono::nanoseconds> cost;
  std::map<std::string, std::chrono::nanoseconds> used;
};

TEST_F(FairQueueTest, ServesOneTenantInItsOrder) {
  std::string order;
  for (const char c : std::string("abc")) queue.push("a", [&order, c] { order += c; });
  while (!queue.empty()) queue.pop()->work();
  EXPECT_EQ(order, "abc");
  EXPECT_FALSE(queue.pop());
}

TEST_F(FairQueueTest, GivesTenantsEqualTimeWhateverTheirWorkCosts) {
  cost = {{"cheap", 100us}, {"dear", 10ms}, {"odd", 3700us}};
  for (const auto& [tenant, one] : cost) push(tenant, 20000);
  serve(5000);
  const double share =
      static_cast<double>((used["cheap"] + used["dear"] + used["odd"]).count()) / 3;
  for (const auto& [tenant, time] : used) {
    EXPECT_NEAR(static_cast<double>(time.count()) / share, 1, 0.05) << tenant;
  }
}

TEST_F(FairQueueTest, GivesNoMoreToWhomAsksMore) {
  cost = {{"greedy", 1ms}, {"modest", 1ms}};
  push("greedy", 10000);
  // The modest one has one piece of work at a time, as a session with one view has.
  for (int i = 0; i < 1000; ++i) {
    push("modest");
    while (serve() != "modest") {
    }
  }
  EXPECT_LE(used["greedy"], used["modest"] * 2);
}

TEST_F(FairQueueTest, LetsANewcomerWaitForOnePieceOfWorkAtMost) {
  cost = {{"greedy", 200ms}, {"newcomer", 1ms}};
  push("greedy", 1000);
  serve(100);
  push("newcomer");
  EXPECT_EQ(serve(), "newcomer");
}

TEST_F(FairQueueTest, RemembersDebtsOfWhomHasNothingWaiting) {
  // One of them comes with one dear piece at a time, and is never in the queue while it is charged.
  cost = {{"dear", 50ms}, {"cheap", 1ms}};
  push("cheap", 10000);
  for (int i = 0; i < 20; ++i) {
    push("dear");
    while (serve() != "dear") {
    }
  }
  EXPECT_GE(used["cheap"] + 60ms, used["dear"]);
}

TEST_F(FairQueueTest, SavesNoCreditUp) {
  cost = {{"a", 1ms}, {"b", 1ms}, {"away", 1ms}};
  push("away");
  serve();
  push("a", 3000);
  push("b", 3000);
  serve(2000);
  push("away", 1000);
  used.clear();
  serve(300);
  EXPECT_NEAR(static_cast<double>(used["away"] / 1ms), 100, 5);
}

TEST_F(FairQueueTest, GoesOnWhenWorkCostsNothing) {
  push("a", 10);
  push("b", 10);
  serve(20);
  EXPECT_TRUE(queue.empty());
}

}  // namespace
}  // namespace culld::server
