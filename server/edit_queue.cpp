#include "server/edit_queue.h"

#include <utility>

namespace culld::server {

EditQueue::EditQueue(std::size_t threads) {
  for (std::size_t i = 0; i < threads; ++i) threads_.emplace_back([this] { run(); });
}

EditQueue::~EditQueue() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  wake_.notify_all();
  for (std::thread& thread : threads_) thread.join();
}

void EditQueue::post(ScenePtr scene, EditJob job, std::function<void(EditDone)> done) {
  {
    const std::lock_guard lock(mutex_);
    const auto [line, fresh] = lines_.try_emplace(scene);
    line->second.jobs.push_back(std::move(job));
    line->second.done.push_back(std::move(done));
    if (!fresh) return;  // its turn comes, or comes again
    turns_.push_back(std::move(scene));
  }
  wake_.notify_one();
}

void EditQueue::run() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return stopping_ || !turns_.empty(); });
    if (stopping_) return;
    const ScenePtr scene = std::move(turns_.front());
    turns_.pop_front();
    Line line = std::exchange(lines_[scene], {});
    lock.unlock();
    work(*scene, std::move(line));
    lock.lock();
    if (lines_[scene].jobs.empty()) {
      lines_.erase(scene);
    } else {
      turns_.push_back(scene);
      wake_.notify_one();
    }
  }
}

void EditQueue::work(Scene& scene, Line line) {
  std::vector<EditDone> outcomes = runEdits(scene, line.jobs);
  for (std::size_t i = 0; i < outcomes.size(); ++i) line.done[i](std::move(outcomes[i]));
  scene.tidy();
}

}  // namespace culld::server
