#include "culling/core/parallel.h"

#include <algorithm>
#include <atomic>
#include <thread>
#include <vector>

namespace culld {

void parallelFor(std::size_t count, const std::function<void(std::size_t)>& work,
                 std::size_t threads) {
  if (threads == 0) threads = std::max(1U, std::thread::hardware_concurrency());
  threads = std::min(threads, count);
  std::atomic<std::size_t> next{0};
  const auto run = [&] {
    for (std::size_t i = next++; i < count; i = next++) work(i);
  };
  if (threads <= 1) {
    run();
    return;
  }
  std::vector<std::jthread> others;
  others.reserve(threads - 1);
  for (std::size_t i = 1; i < threads; ++i) others.emplace_back(run);
  run();
}

}  // namespace culld
