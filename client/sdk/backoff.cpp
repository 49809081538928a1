#include "client/sdk/backoff.h"

#include <algorithm>
#include <cmath>

namespace culld::client {

using std::chrono::milliseconds;

Backoff::Backoff(const Reconnect& rule, std::uint32_t seed) : rule_(rule), random_(seed) {
  rule_.first = std::max(rule_.first, milliseconds(1));
  rule_.longest = std::max(rule_.longest, rule_.first);
  rule_.factor = rule_.factor >= 1.0 ? rule_.factor : 1.0;  // not a number neither
  rule_.jitter = rule_.jitter >= 0.0 ? std::min(rule_.jitter, 1.0) : 0.0;
}

std::optional<milliseconds> Backoff::next() {
  if (!rule_.enabled) return std::nullopt;
  if (rule_.max_attempts != 0 && attempts_ >= rule_.max_attempts) return std::nullopt;
  const double longest = static_cast<double>(rule_.longest.count());
  const double grown = static_cast<double>(rule_.first.count()) *
                       std::pow(rule_.factor, static_cast<double>(attempts_));
  const double share = std::uniform_real_distribution<double>(0.0, rule_.jitter)(random_);
  ++attempts_;
  return milliseconds(std::llround(std::min(grown, longest) * (1.0 - share)));
}

void Backoff::held(std::chrono::nanoseconds time) {
  if (time >= rule_.longest) attempts_ = 0;
}

}  // namespace culld::client
