// `culld bench`: error against run time of scenes x methods x settings, as a report for people
// (docs/bench.md).
#pragma once
#include <span>
#include <string>
#include <vector>

#include "culling/culler.h"

namespace culld {

/// Runs the command with the arguments that follow the word `bench`. Returns the exit code of the
/// program; 1 if any answer broke its promise. REQUIRES: one of `methods` is "frustum".
int runBench(std::vector<std::string> arguments, std::span<const Method* const> methods);

}  // namespace culld
