#include "server/worker_pool.h"

#include <algorithm>
#include <exception>

namespace culld::server {

WorkerPool::WorkerPool(std::size_t threads, const Clock& clock) : clock_(clock) {
  if (threads == 0) threads = std::max<std::size_t>(1, std::thread::hardware_concurrency());
  threads_.reserve(threads);
  for (std::size_t i = 0; i < threads; ++i) threads_.emplace_back([this] { run(); });
}

WorkerPool::~WorkerPool() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
    queue_.clear();
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void WorkerPool::post(std::string payer, std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    if (stopping_) return;
    queue_.push(std::move(payer), std::move(work));
  }
  wake_.notify_one();
}

void WorkerPool::run() {
  for (;;) {
    FairQueue::Item item;
    {
      std::unique_lock lock(mutex_);
      wake_.wait(lock, [this] { return stopping_ || !queue_.empty(); });
      if (stopping_) return;
      item = *queue_.pop();
    }
    const auto started = clock_.now();
    try {
      item.work();
    } catch (const std::exception&) {
      // Work answers for its own failures; what still escapes must not end the daemon.
    }
    item.work = nullptr;  // what it holds ends before the next wait
    const auto cost = clock_.now() - started;
    const std::lock_guard lock(mutex_);
    queue_.charge(item.payer, cost);
  }
}

}  // namespace culld::server
