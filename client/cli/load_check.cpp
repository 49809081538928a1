#include "client/cli/load_check.h"

#include <utility>

namespace culld::client {

Result<std::unique_ptr<LoadCheck>> LoadCheck::start(const Server& server, const std::string& scene,
                                                    const std::string& method) {
  auto connection = Connection::open(server.address, scene, server.once());
  if (!connection) return std::move(connection).error();
  return std::unique_ptr<LoadCheck>(new LoadCheck(std::move(connection).value(), method));
}

LoadCheck::LoadCheck(std::unique_ptr<Connection> connection, std::string method)
    : connection_(std::move(connection)), method_(std::move(method)), thread_([this] { run(); }) {}

LoadCheck::~LoadCheck() { finish(); }

void LoadCheck::offer(const Camera& camera, const Demand& demand, FramePtr frame) {
  constexpr std::size_t kMaxWaiting = 64;
  const std::lock_guard lock(mutex_);
  if (waiting_.size() >= kMaxWaiting || ending_) return;
  waiting_.push_back({camera, demand, std::move(frame)});
  more_.notify_one();
}

void LoadCheck::finish() {
  {
    const std::lock_guard lock(mutex_);
    ending_ = true;
    more_.notify_one();
  }
  if (thread_.joinable()) thread_.join();
}

void LoadCheck::run() {
  for (;;) {
    std::unique_lock lock(mutex_);
    more_.wait(lock, [this] { return ending_ || !waiting_.empty(); });
    if (waiting_.empty()) return;
    const Sample sample = std::move(waiting_.front());
    waiting_.pop_front();
    lock.unlock();
    compare(sample);
  }
}

/// In a view that has seen nothing before: its first answer holds the whole set.
void LoadCheck::compare(const Sample& sample) {
  auto view = connection_->openView(method_);
  if (!view) return;
  const auto whole = view.value().cull(sample.camera, sample.demand);
  if (!whole || whole.value()->scene_version != sample.frame->scene_version) return;
  ++compared_;
  if (whole.value()->visible != sample.frame->visible) ++wrong_;
}

}  // namespace culld::client
