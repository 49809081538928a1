// Turns answers of the wire into whole frames: applies changes to the frame they change, and
// believes nothing that the count and the hash of the set do not confirm (docs/protocol.md "Sets of
// ids").
#pragma once
#include <cstddef>
#include <cstdint>
#include <deque>

#include "culld/connection.h"

namespace culld::client {

/// The frames of one view that the server may still refer to. THREADS: one at a time.
class FrameHistory {
 public:
  /// The frame that `answer` to the view's camera number `camera` makes. ERROR: kInvalidInput
  /// saying what does not fit; then the view must ask for a whole answer by acknowledging frame 0,
  /// as newestNumber() does from here on.
  Result<FramePtr> apply(const protocol::Answer& answer, std::uint64_t camera,
                         std::size_t wire_bytes);

  /// What to acknowledge; 0: nothing held.
  std::uint32_t newestNumber() const noexcept;
  FramePtr newest() const;

  /// The server refers to no frame before `number` any more.
  void forgetBefore(std::uint32_t number);
  /// The server refers to no frame at all: another scene, other ids.
  void forgetAll();

  std::size_t size() const noexcept { return frames_.size(); }

 private:
  Result<FramePtr> rebuilt(const protocol::Answer& answer, std::uint64_t camera,
                           std::size_t wire_bytes) const;

  std::deque<FramePtr> frames_;  ///< ascending
};

}  // namespace culld::client
