// Memory asked for ahead of time: a walk that knows where it goes next need not wait there.
#pragma once
#include <cstddef>

namespace culld {

/// A hint that all of `object` will be read soon.
template <typename T>
void prefetch(const T& object) noexcept {
  const auto* bytes = reinterpret_cast<const char*>(&object);
  for (std::size_t at = 0; at < sizeof(T); at += 64) __builtin_prefetch(bytes + at);
}

}  // namespace culld
