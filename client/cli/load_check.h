// Asks some cameras of a load run once more, on a connection of its own and for the whole set, and
// compares: were the changes that a busy client was sent the right ones?
#pragma once
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>

#include "client/cli/commands.h"
#include "culld/connection.h"

namespace culld::client {

class LoadCheck {
 public:
  /// ERROR: no connection, no view.
  static Result<std::unique_ptr<LoadCheck>> start(const Server& server, const std::string& scene,
                                                  const std::string& method);
  ~LoadCheck();

  /// Takes a sample; when it has too many that wait it takes none. THREADS: any.
  void offer(const Camera& camera, const Demand& demand, FramePtr frame);

  /// Ends; from then on the counts stand.
  void finish();
  std::uint64_t compared() const noexcept { return compared_; }
  std::uint64_t wrong() const noexcept { return wrong_; }

 private:
  struct Sample {
    Camera camera;
    Demand demand;
    FramePtr frame;
  };
  explicit LoadCheck(std::unique_ptr<Connection> connection, std::string method);
  void run();
  void compare(const Sample& sample);

  std::unique_ptr<Connection> connection_;
  const std::string method_;
  std::mutex mutex_;
  std::condition_variable more_;
  std::deque<Sample> waiting_;
  bool ending_ = false;
  std::atomic<std::uint64_t> compared_ = 0, wrong_ = 0;
  std::thread thread_;
};

}  // namespace culld::client
