// Work that splits into independent numbered parts (loading, preparing, many cameras).
#pragma once
#include <cstddef>
#include <functional>

namespace culld {

/// Calls work(i) once for every i in [0, count), on up to `threads` threads (0 = as many as cores).
/// Returns when all are done. REQUIRES: work does not throw and its calls do not touch each other.
void parallelFor(std::size_t count, const std::function<void(std::size_t)>& work,
                 std::size_t threads = 0);

}  // namespace culld
