// Order statistics for summaries.
#pragma once
#include <algorithm>
#include <cstddef>
#include <vector>

namespace culld::client {

/// Nearest rank: the smallest value that at least `percent` of 100 values do not exceed; 0 of none.
template <typename T>
T percentile(std::vector<T> values, std::size_t percent) {
  if (values.empty()) return T{};
  const std::size_t rank = (values.size() * percent + 99) / 100;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank > 0 ? rank - 1 : 0);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace culld::client
