// Threads that work off a queue, first come first served.
#pragma once
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>
#include <vector>

namespace culld::server {

class WorkerPool {
 public:
  /// 0 threads: as many as cores.
  explicit WorkerPool(std::size_t threads);
  /// Drops what has not begun and waits for what has.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// REQUIRES: work does not throw. THREADS: any.
  void post(std::function<void()> work);
  std::size_t threadCount() const noexcept { return threads_.size(); }

 private:
  void run();

  std::mutex mutex_;
  std::condition_variable wake_;
  std::deque<std::function<void()>> queue_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace culld::server
