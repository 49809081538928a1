// Threads that work off a queue that is fair to tenants; the work of one comes first come, first
// served.
#pragma once
#include <condition_variable>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "culling/core/clock.h"
#include "server/fair_queue.h"

namespace culld::server {

class WorkerPool {
 public:
  /// 0 threads: as many as cores. `clock` measures what work costs, and outlives the pool.
  WorkerPool(std::size_t threads, const Clock& clock);
  /// Drops what has not begun and waits for what has.
  ~WorkerPool();
  WorkerPool(const WorkerPool&) = delete;
  WorkerPool& operator=(const WorkerPool&) = delete;

  /// `payer` is the name of the tenant for whom it is done.
  /// REQUIRES: work does not throw. THREADS: any.
  void post(std::string payer, std::function<void()> work);

 private:
  void run();

  const Clock& clock_;
  std::mutex mutex_;
  std::condition_variable wake_;
  FairQueue queue_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace culld::server
