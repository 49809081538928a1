#include "server/worker_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <future>

namespace culld::server {
namespace {

using namespace std::chrono_literals;

class StillClock : public Clock {
 public:
  std::atomic<std::chrono::nanoseconds> time{0ns};
  std::chrono::nanoseconds now() const noexcept override { return time; }
};

TEST(WorkerPool, MeasuresWhatWorkCostsAndIsFairByIt) {
  StillClock clock;
  std::string order;
  std::promise<void> go;
  std::promise<void> done;
  WorkerPool pool(1, clock);
  pool.post("first", [held = go.get_future().share()] { held.wait(); });
  const auto work = [&](char name, std::chrono::nanoseconds cost) {
    return [&, name, cost] {
      order += name;
      clock.time = clock.time.load() + cost;
    };
  };
  for (int i = 0; i < 4; ++i) pool.post("greedy", work('g', 10ms));
  for (int i = 0; i < 4; ++i) pool.post("modest", work('m', 1ms));
  pool.post("greedy", [&done] { done.set_value(); });
  go.set_value();
  done.get_future().wait();
  EXPECT_EQ(order, "gmmmmggg") << "one piece of the greedy one's is worth ten of the other's";
}

TEST(WorkerPool, OutlivesWorkThatThrows) {
  StillClock clock;
  std::promise<void> done;
  WorkerPool pool(1, clock);
  pool.post("", [] { throw std::runtime_error("out of memory, say"); });
  pool.post("", [&done] { done.set_value(); });
  done.get_future().wait();
}

}  // namespace
}  // namespace culld::server
