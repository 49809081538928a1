// `culld plan`: what was measured of a scene, what is used for it, what is left out and why
// (docs/planner.md).
#pragma once
#include <string>
#include <vector>

namespace culld {

/// Runs the command with the arguments that follow the word `plan`. Returns the exit code of the
/// program.
int runPlan(std::vector<std::string> arguments);

}  // namespace culld
