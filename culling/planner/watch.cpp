#include "culling/planner/watch.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>

namespace culld {
namespace {

constexpr int kRetryShare = 32;    ///< one part in so many of the work without it goes to retries
constexpr int kPatience = 4;       ///< costs saved up before a retry in a view that has not changed
constexpr int kMostTrust = 8;      ///< wrong words of the plan before it is believed no more
constexpr int kLongestMemory = 4;  ///< wasted frames that a long good time makes up for

/// Zero for an orthographic camera: then only the place counts.
glm::dvec3 directionOf(const Camera& camera) {
  const glm::dvec3 forward(camera.w_row);
  const double length = glm::length(forward);
  return length > 0.0 ? forward / length : glm::dvec3(0.0);
}

double shareOf(std::uint32_t answered, std::uint32_t in_frustum) {
  return in_frustum == 0 ? 1.0 : static_cast<double>(answered) / in_frustum;
}

double reachOf(const std::vector<PlannedView>& views) {
  glm::dvec3 low(std::numeric_limits<double>::max()), high(-low);
  for (const PlannedView& view : views) {
    low = glm::min(low, view.camera.origin_world);
    high = glm::max(high, view.camera.origin_world);
  }
  const double reach = views.empty() ? 1.0 : 0.5 * glm::length(high - low);
  return reach > 0.0 ? reach : 1.0;
}

}  // namespace

Watch::Watch(std::shared_ptr<const Plan> plan, std::size_t stage)
    : plan_(std::move(plan)),
      stage_(&plan_->stages[stage]),
      reach_(reachOf(stage_->views)),
      trust_(kMostTrust) {
  if (!stage_->built) {  // one place is enough to be off everywhere
    places_.push_back({false, false, Work{0}, stage_->meanWork(), stage_->meanBaseShare()});
    return;
  }
  const Work mean = stage_->meanGain();
  for (const PlannedView& view : stage_->views) {
    // One view says little about its surroundings, so half of the word has the whole scene.
    places_.push_back({(view.gain + mean).count() > 0, false, Work{0}, view.work,
                       shareOf(view.base_visible, view.in_frustum)});
  }
}

std::size_t Watch::placeOf(const Camera& camera) const {
  if (places_.size() <= 1) return 0;
  const glm::dvec3 direction = directionOf(camera);
  std::size_t nearest = 0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const Camera& sampled = stage_->views[i].camera;
    const glm::dvec3 apart = (camera.origin_world - sampled.origin_world) / reach_;
    const double distance =
        glm::dot(apart, apart) + 0.5 * (1.0 - glm::dot(direction, directionOf(sampled)));
    if (distance < least) {
      least = distance;
      nearest = i;
    }
  }
  return nearest;
}

bool Watch::wantsStage(const Camera& camera) {
  here_ = placeOf(camera);
  return planned(places_[here_]) || mayRetry();
}

/// Only if it could pay at all and is affordable; sooner if the view is not the one of the last
/// try.
bool Watch::mayRetry() const {
  const Work cost = places_[here_].expected;
  if (plan_->object_price * baseAnswers(places_[here_]) <= cost) return false;
  const bool changed = here_ != tried_place_ || in_frustum_ > 2 * tried_in_frustum_ ||
                       2 * in_frustum_ < tried_in_frustum_;
  return saved_up_ >= (changed ? cost : cost * kPatience);
}

void Watch::switchTo(Place& place, bool on) {
  place.on = on;
  place.balance = Work{0};
  ++switches_;
}

void Watch::sawStage(const WatchedFrame& frame) {
  Place& place = places_[here_];
  place.expected = frame.work;
  // Cut short, a frame does not say what would have been answered without the stage.
  if (frame.in_frustum != 0) in_frustum_ = frame.in_frustum;
  const std::int64_t left_out = baseAnswers(place) - static_cast<std::int64_t>(frame.visible);
  const Work gain = plan_->object_price * std::max<std::int64_t>(left_out, 0) - frame.work;
  const bool was_planned = planned(place);
  learn(place, gain.count() > 0);
  if (was_planned) {
    place.balance = std::min(place.balance + gain, frame.work * kLongestMemory);
    if (place.balance < -frame.work * 3 / 4) switchTo(place, false);
    return;
  }
  ++retries_;
  saved_up_ -= frame.work;
  tried_place_ = here_;
  tried_in_frustum_ = in_frustum_;
  if (gain > frame.work / 4) {
    switchTo(place, true);
  } else {
    place.on = false;
  }
}

/// The plan's word on places is believed as long as it proves right.
void Watch::learn(Place& place, bool pays) {
  if (!place.visited) trust_ = std::clamp(trust_ + (pays == place.on ? 1 : -1), 0, kMostTrust);
  place.visited = true;
}

std::int64_t Watch::baseAnswers(const Place& place) const {
  return std::llround(place.base_share * in_frustum_);
}

void Watch::sawBase(const WatchedFrame& frame) {
  const bool counted = frame.in_frustum != 0 || frame.visible == 0;
  if (counted) in_frustum_ = frame.in_frustum;
  if (frame.in_frustum != 0) places_[here_].base_share = shareOf(frame.visible, frame.in_frustum);
  saved_up_ = std::min(saved_up_ + frame.work / kRetryShare,
                       std::max(saved_up_, places_[here_].expected * kPatience));
}

}  // namespace culld
