#include "client/sdk/frame_history.h"

#include <algorithm>
#include <string>

#include "protocol/id_set.h"

namespace culld::client {
namespace {

/// One flag per visible object out of eight per byte, lowest bit first.
std::vector<std::uint8_t> unpackBits(const std::vector<std::uint8_t>& bits, std::size_t count) {
  std::vector<std::uint8_t> flags(count);
  for (std::size_t i = 0; i < count; ++i) {
    flags[i] = static_cast<std::uint8_t>((static_cast<unsigned>(bits[i / 8]) >> (i % 8)) & 1U);
  }
  return flags;
}

Error misfit(const protocol::Answer& answer, const std::string& what) {
  return protocol::invalidInput("view " + std::to_string(answer.view) + ": frame " +
                                std::to_string(answer.frame) + ": " + what);
}

}  // namespace

Result<FramePtr> FrameHistory::apply(const protocol::Answer& answer, std::uint64_t camera,
                                     std::size_t wire_bytes) {
  auto frame = rebuilt(answer, camera, wire_bytes);
  if (!frame) {
    forgetAll();
    return frame;
  }
  frames_.push_back(frame.value());
  return frame;
}

Result<FramePtr> FrameHistory::rebuilt(const protocol::Answer& answer, std::uint64_t camera,
                                       std::size_t wire_bytes) const {
  if (answer.frame <= newestNumber()) return misfit(answer, "is older than the one held");
  static const std::vector<std::uint32_t> kNothing;
  const std::vector<std::uint32_t>* baseline = &kNothing;
  if (answer.baseline != 0) {
    const auto held = std::find_if(frames_.begin(), frames_.end(), [&answer](const FramePtr& f) {
      return f->number == answer.baseline;
    });
    if (held == frames_.end()) {
      return misfit(answer,
                    "changes frame " + std::to_string(answer.baseline) + ", which is not held");
    }
    baseline = &(*held)->visible;
  }
  auto ids = protocol::decodeSet(answer.encoding, answer.payload, answer.scene_objects, *baseline);
  if (!ids) return misfit(answer, ids.error().message);
  if (ids.value().size() != answer.object_count) return misfit(answer, "has a wrong count");
  if (protocol::setHash(ids.value()) != answer.set_hash) return misfit(answer, "has a wrong hash");
  const std::size_t seen_bytes = (ids.value().size() + 7) / 8;
  if (!answer.seen.empty() && answer.seen.size() != seen_bytes) {
    return misfit(answer, "marks too few or too many objects as seen");
  }

  auto frame = std::make_shared<Frame>();
  frame->number = answer.frame;
  frame->camera = camera;
  frame->visible = std::move(ids).value();
  if (!answer.seen.empty()) frame->seen = unpackBits(answer.seen, frame->visible.size());
  frame->seen_count = answer.seen_count;
  frame->kept_count = answer.kept_count;
  frame->scene_version = answer.scene_version;
  frame->scene_objects = answer.scene_objects;
  frame->guarantee = answer.guarantee;
  frame->missed_px = answer.missed_px;
  frame->proven = answer.proven;
  frame->out_of_budget = answer.out_of_budget;
  frame->method = answer.method;
  frame->note = answer.note;
  frame->made_by = answer.made_by;
  frame->superseded = answer.superseded;
  frame->stats = answer.stats;
  frame->wire_bytes = wire_bytes;
  frame->delta = answer.baseline != 0;
  return FramePtr(std::move(frame));
}

std::uint32_t FrameHistory::newestNumber() const noexcept {
  return frames_.empty() ? 0 : frames_.back()->number;
}

FramePtr FrameHistory::newest() const { return frames_.empty() ? nullptr : frames_.back(); }

void FrameHistory::forgetBefore(std::uint32_t number) {
  while (!frames_.empty() && frames_.front()->number < number) frames_.pop_front();
}

void FrameHistory::forgetAll() { frames_.clear(); }

}  // namespace culld::client
