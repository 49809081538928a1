// Which SIMD target the kernels use. All targets give equal bytes; forcing one is for tests and
// doubt.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "culling/core/result.h"

namespace culld {

/// The targets that this build has and this CPU runs, best first, e.g. {"avx3", "avx2", "sse4"},
/// whichever is forced.
std::vector<std::string> simdTargets();

/// Uses `name` from now on, in the whole process. "auto" goes back to the best one.
/// ERROR: kInvalidInput: not one of simdTargets(), and nothing changes. THREADS: call before the
/// first cull.
Result<void> forceSimdTarget(std::string_view name);

/// The one in use: the best unless another was forced.
std::string activeSimdTarget();

}  // namespace culld
