// Edits wait for the disk, so they have threads of their own and keep no camera waiting. Those of
// one scene that come while its last are being kept are then kept together: one sync for all.
#pragma once
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "server/jobs.h"

namespace culld::server {

class EditQueue {
 public:
  explicit EditQueue(std::size_t threads);
  /// Drops what has not begun and waits for what has.
  ~EditQueue();
  EditQueue(const EditQueue&) = delete;
  EditQueue& operator=(const EditQueue&) = delete;

  /// Jobs of one scene are carried out in the order of their posts; `done` runs on a thread of the
  /// queue. REQUIRES: `done` does not throw. THREADS: any.
  void post(std::shared_ptr<Scene> scene, EditJob job, std::function<void(EditDone)> done);

 private:
  struct Line {  ///< of one scene
    std::vector<EditJob> jobs;
    std::vector<std::function<void(EditDone)>> done;
  };
  using ScenePtr = std::shared_ptr<Scene>;

  void run();
  static void work(Scene& scene, Line line);

  std::mutex mutex_;
  std::condition_variable wake_;
  std::map<ScenePtr, Line> lines_;  ///< of scenes that wait for a turn or have theirs
  std::deque<ScenePtr> turns_;
  bool stopping_ = false;
  std::vector<std::thread> threads_;
};

}  // namespace culld::server
