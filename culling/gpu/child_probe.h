// Tries something in a child process first: what crashes or hangs there, as drivers and their
// compilers do, has done so to nobody else.
#pragma once
#include <chrono>
#include <functional>

#include "culling/core/result.h"

namespace culld::gpu {

/// The result of `attempt`, run in a child made by fork(). ERROR: kUnavailable: also if the child
/// ended by a signal or was not done after `limit`, and was killed. REQUIRES: this process has no
/// other threads that hold locks which `attempt` needs. THREADS: one.
Result<void> tryInChild(const std::function<Result<void>()>& attempt,
                        std::chrono::milliseconds limit);

}  // namespace culld::gpu
