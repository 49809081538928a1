#include "client/cli/load_run.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <thread>
#include <utility>

#include "protocol/answer_file.h"
#include "protocol/camera_file.h"

namespace culld::client {
namespace {

/// Without a file: a walk on a circle about the origin, one round in a minute at 60 Hz.
std::vector<Camera> circle() {
  constexpr std::size_t kSteps = 3600;
  constexpr double kRadius = 20.0, kEyeHeight = 1.7;
  std::vector<Camera> cameras(kSteps);
  for (std::size_t i = 0; i < kSteps; ++i) {
    const double a = 2.0 * std::numbers::pi * static_cast<double>(i) / double{kSteps};
    protocol::LookAt look;
    look.eye = {kRadius * std::cos(a), kEyeHeight, kRadius * std::sin(a)};
    look.target = {look.eye[0] - std::sin(a), kEyeHeight, look.eye[2] + std::cos(a)};
    cameras[i].pose = look;
  }
  return cameras;
}

}  // namespace

int LoadRun::start(const Server& server, const LoadArguments& a) {
  arguments_ = &a;
  const auto guarantee = protocol::guaranteeNamed(a.cull.guarantee);
  if (!guarantee) return fail(guarantee.error());
  demand_ = a.cull.demand;
  demand_.guarantee = guarantee.value();
  cameras_ = circle();
  if (!a.cull.cameras.empty()) {
    auto read = protocol::readCameraFile(a.cull.cameras, {a.cull.width_px, a.cull.height_px});
    if (!read) return fail(kUsage, read.error().message);
    cameras_ = std::move(read).value();
  }
  if (cameras_.empty()) return fail(kUsage, a.cull.cameras + ": holds no camera");
  for (Camera& camera : cameras_) {
    camera.radius_m = a.radius_m;
    camera.angle_rad = a.angle_rad;
    poses_.push_back(poseOf(camera));
  }
  allowed_ =
      std::chrono::nanoseconds(std::llround(a.late_ms > 0.0 ? a.late_ms * 1e6 : 1e9 / a.rate_hz));
  const std::size_t views = std::size_t{a.clients} * a.views;
  for (std::uint32_t c = 0; c < a.clients; ++c) {
    auto connection = Connection::open(server.address, a.cull.scene, server.once());
    if (!connection) return fail(connection.error());
    connections_.push_back(std::move(connection).value());
    counts_.push_back(std::make_unique<Counts>());
    for (std::uint32_t v = 0; v < a.views; ++v) {
      auto view = connections_.back()->openView(a.cull.method);
      if (!view) return fail(view.error());
      const std::size_t phase = slots_.size() * cameras_.size() / views;
      slots_.push_back({std::move(view).value(), counts_.back().get(), phase, 0, {}, {}});
    }
  }
  if (a.verify_every == 0) return kFine;
  auto check = LoadCheck::start(server, a.cull.scene, a.cull.method);
  if (!check) return fail(check.error());
  check_ = std::move(check).value();
  return kFine;
}

void LoadRun::ask(Slot& slot, std::uint64_t tick) {
  const std::size_t index = (slot.phase + tick) % cameras_.size();
  const LoadArguments& a = *arguments_;
  const bool bounded = a.radius_m > 0.0 || a.angle_rad > 0.0;
  if (bounded && slot.asked > 0 &&
      withinBound(poses_[index], slot.asked_at, a.radius_m, a.angle_rad)) {
    ++within_;
    return;
  }
  slot.asked_at = poses_[index];
  ++sent_;
  const std::uint64_t camera = ++slot.asked;
  slot.view.setCamera(
      cameras_[index], demand_,
      [this, counts = slot.counts, camera, index, due = slot.due](const Result<FramePtr>& frame) {
        answered(*counts, camera, index, due, frame);
      });
}

void LoadRun::answered(Counts& counts, std::uint64_t camera, std::size_t index,
                       Clock::time_point due, const Result<FramePtr>& frame) {
  const Clock::duration took = Clock::now() - due;
  told_.fetch_add(1, std::memory_order_relaxed);
  if (!frame && ending_) {
    ++counts.unanswered;  // told so because the connection is closed
    return;
  }
  if (!frame) {
    if (counts.failed++ == 0) counts.first_error = frame.error().message;
    return;
  }
  const Frame& answer = *frame.value();
  if (answer.camera != camera) {
    ++counts.superseded;
    return;
  }
  ++counts.answered;
  counts.latency_ns.record(static_cast<std::uint64_t>(std::chrono::nanoseconds(took).count()));
  if (took > allowed_) ++counts.late;
  counts.bytes += answer.wire_bytes;
  counts.deltas += answer.delta ? 1 : 0;
  counts.cull_ns += answer.stats.cull_ns;
  counts.queue_ns += answer.stats.queue_ns;
  // A method with a choice may give two views two supersets of the same truth (ADR 8).
  const bool same_for_all = answer.made_by.empty();
  if (check_ && same_for_all && counts.answered % arguments_->verify_every == 0) {
    check_->offer(cameras_[index], demand_, frame.value());
  }
}

LoadResult LoadRun::run() {
  const LoadArguments& a = *arguments_;
  const double period_ns = 1e9 / a.rate_hz;
  const auto ticks = static_cast<std::uint64_t>(std::ceil(a.seconds * a.rate_hz));
  const auto begin = Clock::now() + std::chrono::milliseconds(50);
  const double count = static_cast<double>(slots_.size());
  // Evenly over the period, as clients that know nothing of each other.
  for (std::uint64_t tick = 0; tick < ticks && anyConnected(); ++tick) {
    for (std::size_t s = 0; s < slots_.size(); ++s) {
      const double at = (static_cast<double>(tick) + static_cast<double>(s) / count) * period_ns;
      slots_[s].due = begin + std::chrono::nanoseconds(std::llround(at));
      std::this_thread::sleep_until(slots_[s].due);
      ask(slots_[s], tick);
    }
  }
  awaitRest();
  LoadResult result;
  result.seconds = std::chrono::duration<double>(Clock::now() - begin).count();
  result.method = slots_.front().view.method();
  for (const Slot& slot : slots_) result.wrong += slot.view.misfits();
  ending_ = true;
  slots_.clear();
  connections_.clear();  // from here on the counts stand
  result.due = ticks * static_cast<std::uint64_t>(count);
  result.within = within_;
  result.sent = sent_;
  for (const auto& counts : counts_) {
    result.answered += counts->answered;
    result.superseded += counts->superseded;
    result.late += counts->late;
    result.failed += counts->failed;
    result.unanswered += counts->unanswered;
    result.bytes += counts->bytes;
    result.deltas += counts->deltas;
    result.cull_ns += counts->cull_ns;
    result.queue_ns += counts->queue_ns;
    result.latency_ns.add(counts->latency_ns);
    if (result.first_error.empty()) result.first_error = counts->first_error;
  }
  if (check_) {
    check_->finish();
    result.compared = check_->compared();
    result.wrong += check_->wrong();
  }
  return result;
}

bool LoadRun::anyConnected() const {
  return std::any_of(connections_.begin(), connections_.end(), [](const auto& connection) {
    return connection->state() == ConnectionState::kConnected;
  });
}

/// What is still on its way, for as long as an answer may sensibly take.
void LoadRun::awaitRest() const {
  const auto until = Clock::now() + std::chrono::seconds(5);
  while (told_ < sent_ && Clock::now() < until) {
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

}  // namespace culld::client
