// What of scenes one context keeps on the GPU: an array each, uploaded when it is first needed; the
// longest unused go first.
#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <list>
#include <span>
#include <vector>

#include "culling/gpu/program.h"

namespace culld::gpu {

class ResidentScenes {
 public:
  /// `most_bytes`: of all arrays together; the one in use is kept whatever its size.
  ResidentScenes(const GlTable& gl, std::size_t most_bytes) : gl_(gl), most_bytes_(most_bytes) {}

  /// The array of that key: of `count` elements, which `fill` appends to a vector when they are not
  /// here. Good until the next call.
  template <typename T, typename Fill>
  const Buffer& get(std::uint64_t key, std::size_t count, const Fill& fill) {
    const auto found =
        std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) { return kept.key == key; });
    if (found != kept_.end()) {
      kept_.splice(kept_.begin(), kept_, found);
      return found->array;
    }
    while (!kept_.empty() && bytes() + count * sizeof(T) > most_bytes_) kept_.pop_back();
    std::vector<T> elements;
    elements.reserve(count);
    fill(elements);
    kept_.push_front({key, Buffer(gl_)});
    kept_.front().array.template upload<T>(elements);
    ++uploads_;
    return kept_.front().array;
  }

  std::size_t bytes() const noexcept {
    std::size_t bytes = 0;
    for (const Kept& kept : kept_) bytes += kept.array.bytes();
    return bytes;
  }
  std::uint64_t uploads() const noexcept { return uploads_; }

 private:
  struct Kept {
    std::uint64_t key;
    Buffer array;
  };
  const GlTable& gl_;
  std::size_t most_bytes_;
  std::list<Kept> kept_;  ///< last used first
  std::uint64_t uploads_ = 0;
};

}  // namespace culld::gpu
